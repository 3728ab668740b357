// Quarter of a cylinder of middle radius 2 about the z axis, length 3, thickness 0.1: one layer of 4 x 3 hexahedra.
Point(1) = {0, 0, 0};
Point(2) = {1.95, 0, 0};
Point(3) = {2.05, 0, 0};
Line(1) = {2, 3};
Transfinite Curve {1} = 2;
turned[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi/2} { Curve{1}; Layers{4}; Recombine; };
all[] = Extrude {0, 0, 3} { Surface{turned[1]}; Layers{3}; Recombine; };
Physical Volume("shell") = {all[1]};
Physical Surface("outside") = {18};
Physical Surface("fixed") = {14};
Physical Curve("rim") = {4};
Physical Curve("corner") = {2};
Physical Point("tip") = {5};
