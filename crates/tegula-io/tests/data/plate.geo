// Plate 2 x 1 of two parts that share the middle line, 4 x 2 quadrilaterals.
// plate-{2,4}-{ascii,binary}.msh: gmsh -2 plate.geo -format msh22|msh41 [-bin]
// plate-4-second-order.msh: with -order 2.
// plate-*-big-endian.msh: the binary files with the bytes of each number reversed.
// plate-4-32-bit.msh: the binary file with 4 bytes for each size_t.
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {2, 0, 0};
Point(4) = {2, 1, 0};
Point(5) = {1, 1, 0};
Point(6) = {0, 1, 0};
Point(7) = {5, 5, 5}; // on no surface
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
Transfinite Curve {1:7} = 3;
Transfinite Surface {1, 2};
Recombine Surface {1, 2};
Physical Point("corner", 10) = {4};
Physical Point("ends", 11) = {1, 4};
Physical Curve("fixed edge") = {6};
Physical Curve("seam") = {7};
Physical Curve(33) = {1, 2};
Physical Surface("left") = {1};
Physical Surface("right") = {2};
Physical Surface("whole") = {1, 2};
