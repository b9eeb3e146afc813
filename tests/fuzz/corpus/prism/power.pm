dtmc
module m
 s : [0..1] init 0;
 [] true -> (s'=pow(9,pow(9,9)));
endmodule
