ctmc
const double mu = 2.5;
const int N = 2;
formula full = q = N;
global g : bool init false;
module queue
  q : [0..N] init 0;
  [take] !full -> 1.5 : (q' = q + 1);
  [serve] q > 0 -> mu : (q' = q - 1) & (g' = true);
endmodule
module server
  b : bool;
  [serve] true -> 1 : (b' = !b);
  [] b & g -> 0.1 * q : (b' = false);
endmodule
module other = server [b = c, serve = stop] endmodule
label "full" = full;
rewards "jobs"
  [serve] true : 2;
  q >= 1 : q / N;
endrewards
