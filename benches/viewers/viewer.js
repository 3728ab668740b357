const canvas = document.querySelector("canvas"), v = new Viewer(canvas), zero = new Float32Array(P);
v.load([{ points: P, outline: false, quads: Uint32Array.from(quads), lines: new Uint32Array(0) }]);
v.fit([-0.5, -0.5, -0.2], [0.5, 0.5, 0.2]);
v.playing = true;
loop((t) => {
  v.meshes[0].move(ref, [[[zero, zero, zs[t]], 1]]);
  v.meshes[0].colour(zs[t], true, [-0.2, 0.2]);
  v.redraw();
});
