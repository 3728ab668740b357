// Quarter of a cylinder of radius 2 about the z axis, length 3, 4 x 3 quadrilaterals.
Point(1) = {0, 0, 0};
Point(2) = {2, 0, 0};
Point(3) = {0, 2, 0};
Circle(1) = {2, 1, 3};
Extrude {0, 0, 3} { Curve{1}; Layers{3}; Recombine; }
Transfinite Curve {1, 2} = 5;
Physical Curve("bottom") = {1};
Physical Curve("top") = {2};
Physical Surface("shell") = {5};
