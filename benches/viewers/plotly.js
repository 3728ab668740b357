const [i, j, k] = [[], [], []];
for (let q = 0; q < quads.length; q += 4) {
  i.push(quads[q], quads[q]);
  j.push(quads[q + 1], quads[q + 2]);
  k.push(quads[q + 2], quads[q + 3]);
}
const [x, y] = [0, 1].map((c) => Array.from({ length: P }, (_, p) => ref[3 * p + c]));
const mesh = { type: "mesh3d", x, y, z: zs[0], i, j, k, intensity: zs[0], cmin: -0.2, cmax: 0.2, colorscale: "Viridis", flatshading: true };
const scene = { aspectmode: "manual", aspectratio: { x: 1, y: 1, z: 0.4 }, zaxis: { range: [-0.2, 0.2] } };
Plotly.newPlot("box", [mesh], { width: 1066, height: 532, margin: { l: 0, r: 0, t: 0, b: 0 }, scene }).then(() =>
  loop((t) => Plotly.restyle("box", { z: [zs[t]], intensity: [zs[t]] })),
);
