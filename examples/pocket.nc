%
O0007 (a pocket beside a clamp, and two holes)
N10 G21 G90 G17 G40
N20 T1 M6
N30 S8000 M3
N40 G0 X-20 Y-10 Z40
N50 Z5
(the pocket)
N60 G1 Z-4 F300
N70 X15 F900
N80 G3 X20 Y-5 J5
N90 G1 Y5
N100 G3 X15 Y10 R5
N110 G1 X-20
N120 Y-10
N130 G0 Z12
(two holes: the second one is below the clamp's arm)
N140 G81 G98 X-32 Y0 Z-12 R3 F200
N150 X34 Y24
N160 G80
(home, too low)
N170 G0 X34 Y-30
N180 Z60
M30
%
