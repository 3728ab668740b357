"""Writes the Gmsh files `views-*.msh` with views of data at nodes and on elements, by Gmsh itself.

    pip install gmsh==4.15.2 && python3 views.py

A rectangle of 2 × 1 with 2 × 1 elements: `t` = 1 + x/2 + y/4 at nodes, at the times 0 (times 7) and 1; `p` = number of the element on elements; `u` with three components.
"""

from pathlib import Path

import gmsh

FOLDER = Path(__file__).resolve().parent

for version, binary in ((2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("plate")
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    for curve in gmsh.model.getEntities(1):
        box = gmsh.model.getBoundingBox(*curve)
        gmsh.model.mesh.setTransfiniteCurve(curve[1], 3 if box[3] - box[0] > 1.5 else 2)
    gmsh.model.mesh.setTransfiniteSurface(1)
    gmsh.model.mesh.setRecombine(2, 1)
    gmsh.model.addPhysicalGroup(2, [1], name="plate")
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    name = str(FOLDER / f"views-{int(version)}-{'binary' if binary else 'ascii'}.msh")
    gmsh.write(name)
    nodes, places, _ = gmsh.model.mesh.getNodes()
    quads = gmsh.model.mesh.getElements(2)[1][0]
    t = [[1 + places[3 * i] / 2 + places[3 * i + 1] / 4] for i in range(len(nodes))]
    views = [("t", "NodeData", nodes, [[[7 * x] for [x] in t], t]), ("p", "ElementData", quads, [[[float(q)] for q in quads]]),
             ("u", "NodeData", nodes, [[[x, 0.0, 1.0] for [x] in t]])]
    for title, kind, tags, steps in views:
        view = gmsh.view.add(title)
        for step, values in enumerate(steps):
            gmsh.view.addModelData(view, step, "plate", kind, tags, values, time=float(step))
        gmsh.option.setNumber("PostProcessing.SaveMesh", 0)
        gmsh.view.write(view, name, append=True)
    gmsh.finalize()
