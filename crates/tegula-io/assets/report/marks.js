"use strict";
/* Marks of a model: supports, loads, joints, bodies, points and sets, with the list by which they are shown. */

/** Headings of the list, and the number of the colour in the palette. */
const SUBJECTS = {
  support: ["Supports", 2], load: ["Loads", 1], joint: ["Joints", 3], body: ["Bodies", 6], mass: ["Masses", 4], point: ["Points", 6], set: ["Sets", 0],
};
/** Shapes of markers, in the order of the shader, as paths in a square from −1 to 1. */
const SYMBOLS = {
  square: "M-.8-.8H.8V.8H-.8z", circle: "M1 0A1 1 0 1 1-1 0A1 1 0 1 1 1 0z", diamond: "M0-1L1 0L0 1L-1 0z", triangle: "M0-1L.87.5H-.87z", cross: "M-.33-1H.33V-.33H1V.33H.33V1H-.33V.33H-1V-.33H-.33z",
};

/** Channels from 0 to 1 of a colour such as #0072b2. */
function channels(code) {
  return [1, 3, 5].map((i) => parseInt(code.slice(i, i + 2), 16) / 255);
}

/** Light colour of a category, channels from 0 to 255; repeats after six. */
function categoryColour(index) {
  return channels(COLOURS.palette[[0, 4, 5, 3, 2, 1][index % 6]]).map((c) => Math.round(255 * (0.45 + 0.55 * c)));
}

/** Lines of an arrow: shaft, and one or two heads of four lines. */
function arrowLines([x, y, z, dx, dy, dz], turning) {
  const length = Math.hypot(dx, dy, dz), out = [];
  if (!(length > 0)) return out;
  const d = [dx / length, dy / length, dz / length], start = [x, y, z], at = (t) => start.map((s, i) => s + t * length * d[i]);
  const least = d.map(Math.abs).reduce((a, v, i, all) => (v < all[a] ? i : a), 0), e = [0, 1, 2].map((i) => (i === least ? 1 : 0));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  let across = cross(d, e);
  across = across.map((c) => c / Math.hypot(...across));
  const sides = [across, across.map((c) => -c), cross(d, across), cross(d, across).map((c) => -c)], size = 0.24 * length;
  out.push(...start, ...at(1));
  for (const tip of turning ? [1, 0.8] : [1])
    for (const side of sides) out.push(...at(tip), ...at(tip - 0.24).map((p, i) => p + 0.38 * size * side[i]));
  return out;
}

/** The marks of a scene. */
class Marks {
  constructor(viewer, shapes, holder) {
    [this.viewer, this.shapes, this.holder] = [viewer, shapes, holder];
    const found = shapes.meshes.findIndex((m) => !m.outline);
    this.mesh = shapes.meshes[found];
    this.list = shapes.scene.marks || [];
    this.drawn = new Map();
  }

  /** Colour of a mark; sets have colours of their own. */
  colour(mark) {
    const [, ink] = SUBJECTS[mark.subject];
    const sets = this.list.filter((m) => m.subject === "set");
    return COLOURS.palette[mark.subject === "set" ? [0, 5, 3, 4, 1, 2][sets.indexOf(mark) % 6] : ink];
  }

  /** Fills the list; all but sets are shown at first. */
  async fill() {
    this.holder.replaceChildren();
    const shown = [];
    for (const [subject, [heading]] of Object.entries(SUBJECTS)) {
      const own = this.list.filter((m) => m.subject === subject);
      if (!own.length) continue;
      const entries = own.map((mark) => {
        const box = element("input", { type: "checkbox", checked: subject !== "set", onchange: () => this.show(mark, box.checked) });
        if (subject !== "set") shown.push(mark);
        const symbol = document.createElementNS("http://www.w3.org/2000/svg", "svg");
        symbol.setAttribute("viewBox", "-1.1 -1.1 2.2 2.2");
        symbol.innerHTML = `<path d="${mark.arrows && !mark.places ? "M-1-.2H.2V-.7L1 0L.2.7V.2H-1z" : SYMBOLS[mark.symbol]}" fill="${this.colour(mark)}"/>`;
        return element("label", {}, box, symbol, element("span", {}, mark.name), element("small", {}, mark.note));
      });
      this.holder.append(element("fieldset", {}, element("legend", {}, heading), ...entries));
    }
    await Promise.all(shown.map((mark) => this.show(mark, true)));
  }

  /** Shows or hides a mark. */
  async show(mark, on) {
    if (on && !this.drawn.has(mark)) this.drawn.set(mark, await this.geometry(mark));
    const drawn = this.drawn.get(mark);
    if (!drawn) return;
    drawn.on = on;
    this.viewer.marks = this.list.map((m) => this.drawn.get(m)).filter((m) => m && m.on);
    this.viewer.redraw();
  }

  /** Points, lines and triangles of a mark on the graphics card. */
  async geometry(mark) {
    const reference = this.mesh?.references[0], points = [], lines = [], faces = [];
    const at = (node) => reference.subarray(3 * node, 3 * node + 3);
    const indices = async (block) => new Uint32Array(await bytesOf(block));
    if (mark.nodes !== undefined) for (const node of await indices(mark.nodes)) points.push(...at(node));
    if (mark.places !== undefined) for (const x of new Float32Array(await bytesOf(mark.places))) points.push(x);
    if (mark.edges !== undefined) for (const node of await indices(mark.edges)) lines.push(...at(node));
    if (mark.quads !== undefined)
      for (const quad of await indices(mark.quads)) {
        const corners = [0, 1, 2, 0, 2, 3].map((c) => this.mesh.quads[4 * quad + c]);
        for (const corner of corners) faces.push(...at(corner));
      }
    if (mark.arrows !== undefined) {
      const numbers = new Float32Array(await bytesOf(mark.arrows));
      for (let i = 0; i < numbers.length; i += 6) lines.push(...arrowLines(numbers.subarray(i, i + 6), mark.turning));
    }
    const symbol = Object.keys(SYMBOLS).indexOf(mark.symbol), size = mark.subject === "set" ? 8 : 11;
    return this.viewer.mark({ colour: channels(this.colour(mark)), symbol, size, points, lines, faces });
  }

  /** Names of the supports, loads and sets that have a node. */
  async having(node) {
    const found = [];
    for (const mark of this.list) {
      const blocks = [mark.nodes, mark.edges].filter((b) => b !== undefined);
      for (const block of blocks) if (new Uint32Array(await bytesOf(block)).includes(node)) found.push(mark.name);
      if (mark.quads === undefined) continue;
      const { quads } = this.mesh;
      if (new Uint32Array(await bytesOf(mark.quads)).some((q) => quads.subarray(4 * q, 4 * q + 4).includes(node))) found.push(mark.name);
    }
    return [...new Set(found)];
  }
}
