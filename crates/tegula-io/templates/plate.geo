// Plate of 2 m by 1 m in two parts. Make the mesh with: gmsh -2 plate.geo -format msh41
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {2, 0, 0};
Point(4) = {2, 1, 0};
Point(5) = {1, 1, 0};
Point(6) = {0, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Line(7) = {2, 5};
Curve Loop(1) = {1, 7, 5, 6};
Plane Surface(1) = {1};
Curve Loop(2) = {2, 3, 4, -7};
Plane Surface(2) = {2};

// Quadrilaterals: a regular grid of 8 by 8 on each part.
Transfinite Curve {1:7} = 9;
Transfinite Surface {1, 2};
Recombine Surface {1, 2};

// Names for the model file.
Physical Point("corner") = {4};
Physical Curve("left") = {6};
Physical Curve("right") = {3};
Physical Surface("thick") = {1};
Physical Surface("thin") = {2};
