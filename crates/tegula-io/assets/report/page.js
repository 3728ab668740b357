"use strict";
/* The page of a report: reads its data, and connects shapes and curves. */

/** Largest number of curves in one plot. */
const MOST_CURVES = 7;
const ENERGIES = ["kinetic", "strain", "potential", "work", "dissipated", "total"];

/** Curves of the history of a part. */
async function histories(holder, part) {
  const columns = await columnsOf(part.history), names = part.history.names, first = columns.get(names[0]);
  const points = names.filter((n) => n.endsWith(".ux") && columns.has(n.slice(0, -3) + ".x")).map((n) => n.slice(0, -3));
  const dynamic = part.analysis === "transient", parameter = dynamic ? "time" : "load factor";
  const position = columns.get("path.position"), unstable = columns.get("path.negative_eigenvalues");
  if (dynamic)
    for (const point of points.slice(0, 4))
      chart(holder, `displacement of ${point}`, parameter, "displacement", first, ["ux", "uy", "uz"].map((c) => ({ name: c, ys: columns.get(`${point}.${c}`) })));
  else {
    const size = (n) => columns.get(n).reduce((a, v) => Math.max(a, Math.abs(v) || 0), 0);
    const all = points.flatMap((p) => ["ux", "uy", "uz"].map((c) => `${p}.${c}`)), largest = Math.max(0, ...all.map(size));
    const moving = all.filter((n) => size(n) > 1e-6 * largest).slice(0, MOST_CURVES);
    const dashed = unstable && Array.from(unstable, (n) => n > 0);
    const curves = moving.map((n) => ({ name: n, xs: columns.get(n), ys: first, dashed }));
    for (const [kind, name, ink] of [["limit", "limit point", 6], ["bifurcation", "bifurcation", 3], ["flutter", "onset of flutter", 1]]) {
      const found = part.critical_points.filter((c) => c.kind === kind), xs = [], ys = [];
      for (const { position: at, load_factor } of found)
        for (const n of moving) {
          const i = position.findIndex((p) => p >= at), u = columns.get(n);
          // Of a run that was killed the history may end before the point.
          if (i < 1) continue;
          const w = (at - position[i - 1]) / (position[i] - position[i - 1] || 1);
          xs.push(u[i - 1] + w * (u[i] - u[i - 1]));
          ys.push(load_factor);
        }
      if (xs.length) curves.push({ name, xs, ys, marks: true, ink });
    }
    if (curves.length) diagram(holder, unstable ? "equilibrium path (dashed: negative eigenvalues)" : "load factor over displacement", "displacement", "load factor", curves);
  }
  const energies = ENERGIES.filter((n) => columns.has(n)).map((n) => ({ name: n, ys: columns.get(n) }));
  if (energies.length) chart(holder, "energies", position ? "position on the path" : parameter, "energy", position || first, energies);
  if (dynamic && columns.has("step_size")) chart(holder, "step size", parameter, "step size", first, [{ name: "step size", ys: columns.get("step_size") }]);
  chooser(holder, columns, names);
}

/** A plot of any column over any other. */
function chooser(holder, columns, names) {
  const box = element("div"), place = element("div");
  const select = (value) => element("select", { onchange: () => draw() }, ...names.map((n) => element("option", { value: n, selected: n === value }, n)));
  const size = (n) => columns.get(n).reduce((a, v) => Math.max(a, Math.abs(v) || 0), 0);
  const moving = names.filter((n) => /\.u[xyz]$/.test(n)).sort((a, b) => size(b) - size(a))[0];
  const [x, y] = [select(names[0]), select(moving || names[1] || names[0])];
  const draw = () => {
    place.replaceChildren();
    diagram(place, `${y.value} over ${x.value}`, x.value, y.value, [{ name: y.value, xs: columns.get(x.value), ys: columns.get(y.value) }]);
  };
  box.append(element("p", {}, element("label", {}, "any column: ", y), element("label", {}, " over ", x)), place);
  holder.append(box);
  draw();
}

/** Amplitudes of the response over the frequency. */
async function responses(holder, part) {
  const columns = await columnsOf(part.response), names = part.response.names;
  const peak = (n) => columns.get(n).reduce((a, v) => Math.max(a, v || 0), 0);
  const sorted = names.filter((n) => n.endsWith(".amplitude")).sort((a, b) => peak(b) - peak(a));
  // Amplitudes of round-off are not drawn.
  const shown = sorted.filter((n) => peak(n) > 1e-9 * peak(sorted[0])).slice(0, MOST_CURVES);
  if (!shown.length) return;
  chart(holder, "frequency response", "frequency", "amplitude", columns.get(names[0]), shown.map((n) => ({ name: n.slice(0, -10), ys: columns.get(n) })), true);
}

async function start() {
  const { parts } = JSON.parse(document.getElementById("data").textContent), plots = document.getElementById("plots");
  for (const part of parts)
    if (part.modes) {
      const rigid = (await columnsOf(part.modes)).get("rigid");
      part.rigid = rigid && Array.from(rigid, Boolean);
    }
  const state = { parts, stage: null };
  if (parts.some((part) => part.scenes.length)) {
    try {
      state.stage = new Stage(document.getElementById("scene"), parts);
      await state.stage.open(0);
    } catch (error) {
      document.getElementById("scene").replaceChildren(element("p", { className: "warnings" }, `The shapes cannot be shown: ${error.message}.`));
    }
  } else document.getElementById("shapes").remove();
  for (const part of parts) {
    if (!part.history && !part.response) continue;
    if (part.name) plots.append(element("h3", {}, part.name));
    const holder = element("div", { className: "plots" });
    plots.append(holder);
    if (part.history) await histories(holder, part);
    if (part.response) await responses(holder, part);
  }
  if (plots && !plots.children.length) document.getElementById("curves").remove();
  return state;
}

window.report = start();
