probabilistic
const double p = 0.25;
const int K = mod(floor(7.5), 4);
module m
  x : [-1..K];
  y : [0..1];
  [a] x < K & (y = 0 => x != 0) -> p/2 : (x' = min(x + 1, K)) + 1 - p/2 : (y' = 1 - y);
  [] x = K ? true : x >= log(8, 2) -> true;
endmodule
init x = 0 & y = 1 endinit
label "end" = x = K;
