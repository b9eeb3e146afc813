dtmc
module m
 s : [0..1] init 0;
 [] true -> (s'=1e400);
endmodule
