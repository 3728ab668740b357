"use strict";
/* Curves by uPlot: histories, and load-displacement diagrams whose abscissa may turn back. */

/** Colours of curves. */
const INKS = COLOURS.palette;

/** Options that all plots have. */
function plotOptions(box, title, x, y) {
  const axis = (label) => ({ label, labelSize: 22, size: 58, stroke: "#444", values: (u, ticks) => ticks.map(shortNumber), grid: { stroke: "#e4e4e4" } });
  return { title, width: Math.max(280, box.clientWidth), height: 280, axes: [{ ...axis(x), size: 40 }, axis(y)], scales: { x: { time: false } } };
}

/** Draws the polyline of a series of a diagram; parts of unstable equilibria are dashed, critical points are marks. */
function polyline(curve) {
  return (u, index) => {
    const { dashed, marks } = curve, [xs, ys] = u.data[index], { ctx } = u, place = (x, y) => [u.valToPos(x, "x", true), u.valToPos(y, "y", true)];
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.lineWidth = 2 * devicePixelRatio;
    ctx.strokeStyle = ctx.fillStyle = u.series[index].colour;
    if (marks)
      for (let i = 0; i < xs.length; i++) {
        ctx.beginPath();
        ctx.arc(...place(xs[i], ys[i]), 5 * devicePixelRatio, 0, 2 * Math.PI);
        ctx.fill();
      }
    else
      for (const dash of [false, true]) {
        ctx.setLineDash(dash ? [6 * devicePixelRatio, 5 * devicePixelRatio] : []);
        ctx.beginPath();
        let joined = false;
        for (let i = 1; i < xs.length; i++) {
          const drawn = Boolean(dashed && dashed[i]) === dash;
          if (drawn && !joined) ctx.moveTo(...place(xs[i - 1], ys[i - 1]));
          if (drawn) ctx.lineTo(...place(xs[i], ys[i]));
          joined = drawn;
        }
        ctx.stroke();
      }
    ctx.restore();
    return null;
  };
}

/** Range of an axis; round-off of a constant is no range, since uPlot cannot tell its ticks apart and counts them without end. */
function roomy(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high)), margin = 0.05 * size || 1;
  return high - low > 1e-9 * size ? uPlot.rangeNum(low, high, 0.1, true) : [low - margin, high + margin];
}

/** Diagram of curves whose abscissa need not increase: `curves` have a name, xs, ys, dashed (for each point) or marks. The plot that is returned shows by
 * `renew` what has become of them. */
function diagram(holder, title, x, y, curves) {
  const box = document.createElement("div");
  holder.append(box);
  const options = plotOptions(box, title, x, y);
  const extent = (key) => {
    const all = curves.flatMap((c) => Array.from(c[key])).filter(Number.isFinite);
    const [low, high] = [all.reduce((a, b) => Math.min(a, b), Infinity), all.reduce((a, b) => Math.max(a, b), -Infinity)];
    if (!all.length) return [0, 1];
    // Round-off of a constant is no range: ticks of uPlot could not be told apart.
    const size = Math.max(Math.abs(low), Math.abs(high)), margin = high - low > 1e-9 * size ? 0.05 * (high - low) : 0.05 * size || 1;
    return [low - margin, high + margin];
  };
  let whole = { x: extent("xs"), y: extent("ys") };
  const range = (key) => (u, low, high) => (u.zoomed && high - low > 1e-9 * (whole[key][1] - whole[key][0]) ? [low, high] : whole[key]);
  options.mode = 2;
  options.scales = { x: { time: false, range: range("x") }, y: { range: range("y") } };
  options.cursor = { dataIdx: () => null, points: { show: false }, drag: { x: true, y: true } };
  options.legend = { live: false };
  options.series = [null, ...curves.map((curve, i) => ({
    label: curve.name, stroke: INKS[(curve.ink ?? i) % INKS.length], colour: INKS[(curve.ink ?? i) % INKS.length],
    facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }], paths: polyline(curve),
  }))];
  options.hooks = { setSelect: [(u) => (u.zoomed = u.select.width > 0)] };
  const data = () => [null, ...curves.map((c) => [Array.from(c.xs), Array.from(c.ys)])], plot = new uPlot(options, data(), box);
  plot.over.addEventListener("dblclick", () => {
    plot.zoomed = false;
    plot.setScale("x", { min: whole.x[0], max: whole.x[1] });
    plot.setScale("y", { min: whole.y[0], max: whole.y[1] });
  });
  plot.renew = () => {
    whole = { x: extent("xs"), y: extent("ys") };
    renewed(plot, data());
  };
  return sized(plot, box);
}

/** Curves over an increasing abscissa. The plot that is returned shows others of the same names by `renew`. */
function chart(holder, title, x, y, xs, curves, logarithmic = false) {
  const box = document.createElement("div");
  holder.append(box);
  const options = plotOptions(box, title, x, y);
  const positive = logarithmic ? curves.flatMap((c) => Array.from(c.ys)).filter((v) => v > 0 && Number.isFinite(v)) : [];
  if (positive.length) {
    // A power that is not rounded as its literal, as 10 ** n may be, sends uPlot into a loop without end.
    const power = (n) => Number(`1e${n}`);
    const [low, high] = [Math.max(positive.reduce((a, b) => Math.min(a, b)), 1e-12 * positive.reduce((a, b) => Math.max(a, b))), positive.reduce((a, b) => Math.max(a, b))];
    options.scales.y = { distr: 3, range: [power(Math.floor(Math.log10(low))), power(Math.ceil(Math.log10(high * 1.0001)))] };
  }
  else options.scales.y = { range: (u, low, high) => roomy(low, high) };
  const value = (u, v) => shortNumber(v);
  options.series = [{ label: x, value }, ...curves.map((curve, i) => ({ label: curve.name, stroke: INKS[i % INKS.length], width: 2, value, points: { show: (u) => u.data[0].length < 40 } }))];
  const clean = (values) => Array.from(values, (v) => (Number.isFinite(v) && (!logarithmic || v > 0) ? v : null));
  options.hooks = { setSelect: [(u) => (u.zoomed = u.select.width > 0)] };
  const data = (xs, curves) => [Array.from(xs), ...curves.map((c) => clean(c.ys))], plot = new uPlot(options, data(xs, curves), box);
  plot.over.addEventListener("dblclick", () => (plot.zoomed = false));
  plot.renew = (xs, curves) => renewed(plot, data(xs, curves));
  return sized(plot, box);
}

/** Shows other data in a plot; a part that was chosen stays. */
function renewed(plot, data) {
  plot.setData(data, !plot.zoomed);
  if (plot.zoomed) plot.redraw();
}

/** Keeps a plot as wide as its place. */
function sized(plot, box) {
  new ResizeObserver(() => box.isConnected && plot.setSize({ width: Math.max(280, box.clientWidth), height: 280 })).observe(box);
  return plot;
}
