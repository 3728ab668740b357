// Two leaf springs, unloaded: each of two halves of the length a, whose width grows linearly from the eye to the seat of the axle.
// Under the force P at each eye the moment is P s at the distance s from it, so that the leaf is flat if its natural curvature is
// P s/(E I). Make the mesh with: gmsh -2 leaf_spring_axle.geo -format msh22
a = 0.6;
track = 0.9;
seat = 0.05;
eye = 0.025;
thickness = 0.01;
young = 206e9;
P = 400*9.81/4;

// Points per half, and steps of the integration from one point to the next.
points = 24;
steps = 20;
ds = a/(points*steps);

// From the seat to the eye: slope, and place along and above the tangent at the seat.
slope = 0;
along[0] = 0;
above[0] = 0;
x = 0;
z = 0;
For i In {1:points}
  For k In {1:steps}
    s = a - ((i - 1)*steps + k - 0.5)*ds;
    curvature = P*s*12/(young*(eye + (seat - eye)*s/a)*thickness^3);
    slope += curvature*ds/2;
    x += Cos(slope)*ds;
    z += Sin(slope)*ds;
    slope += curvature*ds/2;
  EndFor
  along[i] = x;
  above[i] = z;
EndFor

// The front eyes at x = 0, all eyes at z = 0; x points to the rear.
For side In {0:1}
  y = (side - 0.5)*track;
  For half In {0:1}
    For edge In {0:1}
      list[] = {};
      For i In {0:points}
        width = seat + (eye - seat)*i/points;
        p = newp;
        Point(p) = {x + (2*half - 1)*along[i], y + (edge - 0.5)*width, above[i] - z};
        list[] += p;
      EndFor
      first[edge] = list[0];
      last[edge] = list[points];
      If (half == 1)
        // The halves share the points at the seat.
        first[edge] = middle[edge];
        list[0] = middle[edge];
      Else
        middle[edge] = first[edge];
      EndIf
      c = newc;
      Spline(c) = list[];
      long[edge] = c;
    EndFor
    If (half == 0)
      across = newc;
      Line(across) = {first[0], first[1]};
    EndIf
    end = newc;
    Line(end) = {last[0], last[1]};
    loop = newcl;
    Curve Loop(loop) = {across, long[1], -end, -long[0]};
    surface = news;
    Surface(surface) = {loop};
    Transfinite Curve {long[0], long[1]} = 25;
    Transfinite Curve {across, end} = 3;
    Transfinite Surface {surface};
    Recombine Surface {surface};
    ends[2*side + half] = end;
    surfaces[2*side + half] = surface;
  EndFor
  seats[side] = across;
EndFor

// The normals of the leaves point upwards.
Physical Surface("leaves") = {-surfaces[0], surfaces[1], -surfaces[2], surfaces[3]};
Physical Curve("left front end") = {ends[0]};
Physical Curve("left rear end") = {ends[1]};
Physical Curve("right front end") = {ends[2]};
Physical Curve("right rear end") = {ends[3]};
Physical Curve("left seat") = {seats[0]};
Physical Curve("right seat") = {seats[1]};
