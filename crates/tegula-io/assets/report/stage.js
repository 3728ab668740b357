"use strict";
/* Shapes of a page and their controls. */

/** Element with attributes, listeners (names beginning with "on") and children. */
function element(tag, attributes = {}, ...children) {
  const out = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (name.startsWith("on")) out.addEventListener(name.slice(2), value);
    else if (name in out) out[name] = value;
    else out.setAttribute(name, value);
  out.append(...children);
  return out;
}

/** Number for an axis or a legend. */
function shortNumber(x) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  const size = Math.abs(x);
  return size === 0 || (size >= 1e-3 && size < 1e5) ? String(Number(x.toPrecision(6))) : x.toExponential(4).replace(/\.?0+e/, "e");
}

/** Bytes of a block: base64, compressed by zlib. */
async function bytesOf(block) {
  const text = atob(document.getElementById(`block-${block}`).textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Values of a rounded field, one list for each instant: codes are differences from the instant before; 65535 is a gap. */
async function valuesOf(rounded, instants) {
  const codes = new Uint16Array(await bytesOf(rounded.block)), count = codes.length / instants;
  const sum = new Uint16Array(count), { least, greatest } = rounded, out = [];
  const largest = Math.max(Math.abs(least), Math.abs(greatest));
  const Values = largest === 0 || (largest > 1e-30 && largest < 1e38) ? Float32Array : Float64Array;
  for (let t = 0; t < instants; t++) {
    const values = new Values(count);
    for (let i = 0; i < count; i++) {
      sum[i] += codes[t * count + i];
      const part = sum[i] / 65534;
      values[i] = sum[i] === 65535 ? NaN : least * (1 - part) + greatest * part;
    }
    out.push(values);
  }
  return out;
}

/** Columns of a table by their names. */
async function columnsOf(table) {
  const all = new Float64Array(await bytesOf(table.block));
  return new Map(table.names.map((name, i) => [name, all.subarray(i * table.rows, (i + 1) * table.rows)]));
}

/** The scene as typed arrays, with fields decoded on demand. */
class Shapes {
  static async read(scene) {
    const out = new Shapes();
    out.scene = scene;
    out.instants = scene.values.length;
    // The shape of a complex mode a quarter of a period later stands behind it, at the value n + 1/4.
    out.shown = scene.values.map((v, i) => i).filter((i) => scene.kind === "states" || Number.isInteger(scene.values[i]));
    out.meshes = [];
    for (const mesh of scene.meshes) {
      const displacement = mesh.displacement && (await Promise.all(mesh.displacement.map((d) => valuesOf(d, out.instants))));
      out.meshes.push({
        points: mesh.points, outline: mesh.outline, fields: mesh.fields,
        references: await Promise.all(mesh.references.map(async (block) => new Float32Array(await bytesOf(block)))),
        quads: new Uint32Array(await bytesOf(mesh.quads)),
        lines: new Uint32Array(await bytesOf(mesh.lines)),
        displacement: displacement ? scene.values.map((v, t) => displacement.map((d) => d[t])) : null,
      });
    }
    out.cache = new Map();
    return out;
  }

  /** Number of the shape a quarter of a period behind that number `i`, if there is one. */
  quarter(i) {
    const { values } = this.scene;
    return values[i + 1] === values[i] + 0.25 ? i + 1 : -1;
  }

  /** Box of the reference, and the largest displacement at each instant. */
  extent() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], largest = new Float64Array(this.instants);
    for (const { references, displacement, points } of this.meshes) {
      for (const reference of references)
        for (let i = 0; i < reference.length; i++) {
          low[i % 3] = Math.min(low[i % 3], reference[i]);
          high[i % 3] = Math.max(high[i % 3], reference[i]);
        }
      if (displacement)
        displacement.forEach((u, t) => {
          for (let i = 0; i < points; i++) largest[t] = Math.max(largest[t], Math.hypot(u[0][i], u[1][i], u[2][i]) || 0);
        });
    }
    return { low, high, largest, size: Math.hypot(...high.map((h, i) => h - low[i])) || 1 };
  }

  /** Fields by which the shells can be coloured, as pairs of name and label. */
  choices() {
    const shells = this.meshes.find((m) => !m.outline);
    if (!shells) return [];
    const out = this.scene.kind === "model" ? [["", "one colour"], ["side", "side of the directors"]] : shells.displacement ? ["magnitude", "x", "y", "z"].map((c) => [`displacement/${c}`, `displacement ${c}`]) : [];
    for (const { name, components } of shells.fields)
      for (const [component] of components) out.push([`${name}/${component}`, `${name.replaceAll("_", " ")} ${component}`.trim()]);
    return out;
  }

  /** Values of a field at all instants. */
  async field(choice) {
    if (choice === "side") return null;
    if (!this.cache.has(choice)) this.cache.set(choice, await this.decode(choice));
    return this.cache.get(choice);
  }

  async decode(choice) {
    const shells = this.meshes.find((m) => !m.outline), [name, component] = choice.split("/");
    if (name === "displacement") {
      const c = ["x", "y", "z"].indexOf(component);
      const size = ([x, y, z]) => x.map((_, i) => Math.hypot(x[i], y[i], z[i]));
      return { atPoints: true, values: shells.displacement.map((u) => (c < 0 ? size(u) : u[c])) };
    }
    const field = shells.fields.find((f) => f.name === name);
    const [, rounded] = field.components.find(([c]) => c === component);
    return { atPoints: field.at_points, values: await valuesOf(rounded, this.instants), categories: field.categories };
  }
}

/** Least and greatest finite value. */
function rangeOf(lists) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of lists)
    for (const v of values) {
      if (v < low && v > -Infinity) low = v;
      if (v > high && v < Infinity) high = v;
    }
  return [low, high];
}

/** A number of the series 1, 2, 5, 10, … not above x. */
function rounded125(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((f) => f * power <= x * (1 + 1e-9));
}

/** Number of elements beyond which their edges are not shown at first. */
const MOST_EDGED = 20000;

/** Controls and state of the shapes. */
class Stage {
  constructor(holder, parts) {
    this.list = parts.flatMap((part) => part.scenes.map((scene) => ({ part, scene })));
    this.playing = false;
    const button = (text, title, onclick) => element("button", { type: "button", title, onclick }, text);
    const labelled = (text, control) => element("label", {}, text, " ", control);
    this.canvas = element("canvas", { tabIndex: 0 });
    this.canvas.setAttribute("aria-label", "shape of the model; drag or shift and arrows to turn, wheel or i and o to zoom, shift and drag or w a s d to move");
    this.picker = element("select", { onchange: () => this.open(this.picker.selectedIndex) }, ...this.list.map(({ part, scene }) => element("option", {}, part.name ? `${part.name}: ${scene.name}` : scene.name)));
    this.field = element("select", { onchange: () => this.recolour() });
    this.each = element("select", { onchange: () => this.recolour() }, element("option", { value: "all" }, "all states"), element("option", { value: "one" }, "this state"));
    this.map = element("select", { onchange: () => { this.viewer.map(this.map.value); this.update(); } }, ...Object.keys(MAPS).map((name) => element("option", {}, name)));
    this.slider = element("input", { type: "range", min: 0, step: 1, oninput: () => this.at(Number(this.slider.value)) });
    this.slider.setAttribute("aria-label", "state");
    this.play = button("▶", "play or pause (space)", () => this.toggle());
    this.label = element("output");
    this.scale = element("input", { type: "number", step: "any", size: 7, onchange: () => this.update() });
    this.ranges = element("span", { className: "group" }, labelled("range of", this.each), labelled("map", this.map));
    this.colours = element("span", { className: "group" }, labelled("colour", this.field), this.ranges);
    const tick = (key) => element("input", { type: "checkbox", checked: true, onchange: (e) => this.tick(key, e.target.checked) });
    [this.edges, this.undeformed] = [tick("edges"), tick("undeformed")];
    this.edges.title = "fainter where elements are less than 16 pixels high, and left out below 6";
    this.bar = element("div", { className: "bar" });
    this.triad = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.triad.setAttribute("class", "triad");
    this.invitation = element("p", {}, "Click on a shell to see values over time at its nearest node.");
    this.node = element("div", { className: "node" }, this.invitation);
    this.markList = element("div", { className: "marks" });
    const [scale, undeformed] = [labelled("displacements ×", this.scale), labelled("undeformed", this.undeformed)];
    const time = element("div", { className: "time" }, this.play, this.slider, this.label), keys = element("span", {}, " Keys: space plays, ← → step, + − scale.");
    const viewing = " Keys of the view: shift and arrows turn, i and o zoom in and out, w a s d move, r resets.";
    this.ofMotion = [scale, undeformed, time, keys];
    [this.phase, this.due, this.picked] = [0, 0, null];
    holder.append(
      element("div", { className: "controls" }, ...(this.list.length > 1 ? [labelled("show", this.picker)] : []), this.colours, scale, labelled("edges", this.edges), undeformed, button("reset view", "first direction of view (r)", () => this.viewer.reset()), button("save picture", "save the picture as PNG", () => this.save())),
      element("div", { className: "stage" }, this.canvas, this.bar, this.triad),
      time,
      element("p", { className: "hint" }, "Drag to turn, wheel to zoom, shift and drag to move.", keys, viewing),
      this.markList,
      this.node,
    );
    this.viewer = new Viewer(this.canvas);
    this.viewer.onpick = (found) => this.pick(found);
    this.viewer.ondraw = () => this.drawTriad();
    document.addEventListener("keydown", (e) => this.key(e));
  }

  /** Shows or hides edges or the undeformed outline. */
  tick(key, on) {
    this[key].checked = this.viewer.show[key] = on;
    this.viewer.redraw();
  }

  /** Shows another scene. */
  async open(index) {
    const { scene } = this.list[index];
    this.stop();
    const shapes = await Shapes.read(scene);
    // Another scene may have been chosen while this one was read.
    if (this.picker.selectedIndex >= 0 && this.picker.selectedIndex !== index && this.list.length > 1) return;
    await this.present(shapes);
  }

  /** Shows the shapes of a scene that is read. */
  async present(shapes) {
    const { scene } = shapes;
    this.shapes = shapes;
    this.node.replaceChildren(this.invitation);
    this.picked = null;
    this.box = this.shapes.extent();
    [this.modes, this.still] = [scene.kind === "modes", scene.kind === "model"];
    for (const control of this.ofMotion) control.hidden = this.still;
    this.ranges.hidden = this.still;
    const largest = this.box.largest.reduce((a, b) => Math.max(a, b), 0);
    const small = largest > 0 && largest < 0.02 * this.box.size;
    this.scale.value = this.modes || !small ? 1 : rounded125((0.1 * this.box.size) / largest);
    this.slider.max = this.shapes.shown.length - 1;
    this.each.value = this.modes ? "one" : "all";
    const kept = this.field.value, choices = this.shapes.choices();
    this.colours.hidden = this.node.hidden = !choices.length;
    this.field.replaceChildren(...choices.map(([value, label]) => element("option", { value }, label)));
    const first = ["von_mises/", "displacement/magnitude"].find((name) => choices.some(([value]) => value === name));
    this.field.value = choices.some(([value]) => value === kept) ? kept : this.modes ? "displacement/magnitude" : first || "";
    this.viewer.load(this.shapes.meshes);
    this.tick("edges", this.shapes.meshes.reduce((sum, { quads }) => sum + quads.length / 4, 0) <= MOST_EDGED);
    if (this.still) await this.openModel();
    this.viewer.fit(...this.swept());
    this.slider.value = this.modes ? this.firstElastic() : this.slider.max;
    await this.recolour();
  }

  /** Shows the marks of a model, whose sections have colours where there are several. */
  async openModel() {
    const { shapes, viewer } = this, sections = shapes.meshes.find((m) => !m.outline)?.fields.find((f) => f.name === "section");
    if (sections?.categories?.length > 1) this.field.value = "section/";
    this.invitation.textContent = "Click on the mesh to see the number of the nearest node and its sets.";
    this.marks = new Marks(viewer, shapes, this.markList);
    await this.marks.fill();
  }

  /** Box of the shapes that are shown, those of modes and those of at most fifty states. */
  swept() {
    const { shapes, modes, box } = this, low = [...box.low], high = [...box.high];
    if (modes) return [low.map((x) => x - 0.05 * box.size), high.map((x) => x + 0.05 * box.size)];
    const scale = Number(this.scale.value), stride = Math.ceil(shapes.instants / 50);
    for (const { references: [reference], displacement, points } of shapes.meshes) {
      if (!displacement) continue;
      for (let t = shapes.instants - 1; t >= 0; t -= stride)
        for (let i = 0; i < points; i++)
          for (let c = 0; c < 3; c++) {
            const x = reference[3 * i + c] + scale * displacement[t][c][i];
            if (x < low[c]) low[c] = x;
            if (x > high[c]) high[c] = x;
          }
    }
    return [low, high];
  }

  /** Place of the first mode that is not rigid. */
  firstElastic() {
    const rigid = this.list[this.picker.selectedIndex < 0 ? 0 : this.picker.selectedIndex].part.rigid;
    const found = this.shapes.shown.findIndex((_, i) => !(rigid && rigid[i]));
    return Math.max(found, 0);
  }

  get instant() {
    return this.shapes.shown[Number(this.slider.value)];
  }

  /** Colours by the chosen field. */
  async recolour() {
    const { shapes } = this, choice = this.field.value, found = choice ? await shapes.field(choice) : null;
    // A later choice may have been decoded first.
    if (choice !== this.field.value || shapes !== this.shapes) return;
    this.chosen = found;
    this.viewer.sided = choice === "side";
    this.update();
  }

  at(place) {
    this.slider.value = place;
    this.update();
  }

  /** Draws the present state. */
  update() {
    const { shapes, viewer, chosen, instant } = this, scale = Number(this.scale.value);
    if (!shapes) return;
    const factor = this.modes ? (scale * 0.1 * this.box.size) / (this.box.largest[instant] || 1) : scale;
    // A mode moves by its shape times the cosine of the phase, and by that a quarter of a period later times the sine.
    const quarter = shapes.quarter(instant), [cosine, sine] = this.modes ? [Math.cos(this.phase), Math.sin(this.phase)] : [1, 0];
    const names = chosen?.categories;
    if (names) {
      // Each category has a place of its own, though colours repeat.
      viewer.range = [-0.5, names.length - 0.5];
      viewer.paint((t) => categoryColour(Math.min(names.length - 1, Math.floor(t * names.length))));
    } else if (chosen) {
      let [low, high] = this.each.value === "one" ? rangeOf([chosen.values[instant]]) : (chosen.range ??= rangeOf(chosen.values));
      if (this.map.value === "diverging") [low, high] = [-Math.max(-low, high), Math.max(-low, high)];
      viewer.range = low <= high ? [low, high] : [0, 0];
    }
    viewer.meshes.forEach((drawn) => {
      const u = drawn.mesh.displacement, { references } = drawn.mesh, parts = [];
      if (u) parts.push([u[instant], factor * cosine]);
      if (u && quarter >= 0) parts.push([u[quarter], factor * sine]);
      drawn.move(references[references.length > 1 ? instant : 0], parts);
      if (drawn.mesh.outline || !chosen) drawn.colour(null);
      else drawn.colour(chosen.values[instant], chosen.atPoints, viewer.range);
    });
    this.label.textContent = this.labelOf(instant);
    this.slider.setAttribute("aria-valuetext", this.label.textContent);
    this.legend();
    if (this.modes && this.picked) this.tellValues();
    viewer.redraw();
  }

  labelOf(i) {
    const { scene } = this.shapes;
    return scene.labels[i] || `${scene.parameter} ${shortNumber(scene.values[i])}`;
  }

  legend() {
    const names = this.viewer.sided ? ["side of the directors", "other side"] : this.chosen?.categories;
    // The browser lays out the page again for a legend that is replaced, which takes longer than to draw the shape.
    const told = JSON.stringify([names, this.chosen && this.viewer.range, this.field.value, this.map.value]);
    if (told === this.told) return;
    this.told = told;
    this.bar.classList.toggle("names", Boolean(names));
    if (names) {
      const colour = (i) => (this.viewer.sided ? SIDES[i].map((c) => 255 * c) : categoryColour(i));
      const entry = (name, i) => element("span", {}, element("i", { style: `background: rgb(${colour(i).map(Math.round)})` }), name);
      const more = names.length > 12 ? [element("span", {}, `and ${names.length - 12} more`)] : [];
      return this.bar.replaceChildren(...names.slice(0, 12).map(entry), ...more);
    }
    if (!this.chosen) return this.bar.replaceChildren();
    const map = MAPS[this.map.value], [low, high] = this.viewer.range;
    const stops = map.map((_, i) => `rgb(${colourAt(map, i / (map.length - 1))})`);
    const ticks = [1, 0.75, 0.5, 0.25, 0].map((t) => element("span", {}, shortNumber(Number((low * (1 - t) + high * t).toPrecision(4)))));
    this.bar.replaceChildren(element("b", {}, this.field.selectedOptions[0]?.textContent || ""), element("div", { className: "ramp", style: `--stops: ${stops}` }), element("div", { className: "ticks" }, ...ticks));
  }

  drawTriad() {
    const { right, up } = this.viewer.axes(), told = String([right, up]);
    if (told === this.direction) return;
    this.direction = told;
    this.triad.innerHTML = ["x", "y", "z"].map((name, i) => {
      const [x, y] = [40 + 26 * right[i], 40 - 26 * up[i]], [tx, ty] = [40 + 35 * right[i], 44 - 35 * up[i]];
      return `<line x1="40" y1="40" x2="${x}" y2="${y}"/><text x="${tx}" y="${ty}">${name}</text>`;
    }).join("");
  }

  toggle() {
    if (this.playing) {
      this.stop();
      return this.update();
    }
    this.playing = this.viewer.playing = true;
    this.play.textContent = "⏸";
    const last = Number(this.slider.max), { values } = this.shapes.scene, span = values[this.shapes.shown[last]] - values[0];
    // A series lasts six seconds, a period of a mode 1.6.
    const begin = performance.now(), from = Number(this.slider.value) >= last ? 0 : Number(this.slider.value);
    const start = span > 0 ? (values[this.shapes.shown[from]] - values[0]) / span : from / (last || 1);
    const step = (now) => {
      if (!this.playing) return;
      const seconds = Math.max(0, now - begin) / 1000;
      if (this.modes) {
        this.phase = (2 * Math.PI * seconds) / 1.6;
        this.update();
      } else {
        const t = (start + seconds / 6) % 1.08;
        let place = Math.min(last, Math.round(t * last));
        if (span > 0 && t < 1) {
          const value = values[0] + t * span;
          place = 0;
          while (place < last && values[this.shapes.shown[place + 1]] <= value) place++;
        }
        if (place !== Number(this.slider.value)) this.at(place);
      }
      this.due = requestAnimationFrame(step);
    };
    this.due = requestAnimationFrame(step);
  }

  /** Ends the animation; a mode is shown at its largest displacement. */
  stop() {
    cancelAnimationFrame(this.due);
    this.playing = this.viewer.playing = false;
    this.play.textContent = "▶";
    this.phase = 0;
  }

  key(e) {
    if (["INPUT", "SELECT", "TEXTAREA"].includes(e.target.tagName) && e.target.type !== "range") return;
    if (e.ctrlKey || e.metaKey || e.altKey || !this.shapes) return;
    const move = (by) => this.at(Math.max(0, Math.min(Number(this.slider.max), Number(this.slider.value) + by)));
    const scaled = (by) => { this.scale.value = Number((Number(this.scale.value) * by).toPrecision(6)); this.update(); };
    const { viewer } = this, turn = (right, up) => () => viewer.turn(5 * right, 5 * up), shift = (right, up) => () => viewer.pan(20 * right, 20 * up);
    // With marked text shift and arrows mark more or less of it.
    const turns = document.getSelection().isCollapsed ? { ArrowLeft: turn(1, 0), ArrowRight: turn(-1, 0), ArrowUp: turn(0, 1), ArrowDown: turn(0, -1) } : {};
    const views = { r: () => viewer.reset(), i: () => viewer.zoom(0.8), o: () => viewer.zoom(1.25), w: shift(0, -1), a: shift(-1, 0), s: shift(0, 1), d: shift(1, 0) };
    const motions = { " ": () => this.toggle(), ArrowLeft: () => move(-1), ArrowRight: () => move(1), "+": () => scaled(1.25), "-": () => scaled(0.8) };
    const actions = e.shiftKey && e.key.startsWith("Arrow") ? turns : this.still ? views : { ...views, ...motions };
    if (!actions[e.key] || (e.key === " " && e.target.tagName === "BUTTON")) return;
    e.preventDefault();
    actions[e.key]();
  }

  /** Values over time at a node. */
  pick({ mesh, point }) {
    const { shapes, chosen, modes } = this, shells = shapes.meshes[mesh], { references: [reference], displacement, quads } = shells;
    const place = [0, 1, 2].map((c) => shortNumber(reference[3 * point + c])).join(", ");
    const curves = displacement ? ["x", "y", "z"].map((name, c) => ({ name: `displacement ${name}`, ys: displacement.map((u) => u[c][point]) })) : [];
    this.picked = { point, curves };
    this.node.replaceChildren(element("p", {}, `Node ${point} (counted from 0, as in the files) at (${place})`));
    if (this.still) {
      this.marks.having(point).then((names) => this.node.append(element("p", {}, names.length ? `It is in ${names.join(", ")}.` : "No support, load or set has it.")));
      return;
    }
    if (modes || shapes.instants < 2) {
      this.node.append(element("p"));
      this.tellValues();
      return;
    }
    const { values, parameter } = shapes.scene;
    if (curves.length) chart(this.node, "displacement at the node", parameter, "displacement", values, curves);
    if (!chosen || this.field.value.startsWith("displacement/")) return;
    const name = this.field.selectedOptions[0].textContent, cells = [];
    for (let q = 0; q < quads.length; q++) if (quads[q] === point && cells[cells.length - 1] !== q >> 2) cells.push(q >> 2);
    const at = (v) => (chosen.atPoints ? v[point] : cells.reduce((sum, q) => sum + v[q], 0) / cells.length);
    const what = chosen.atPoints ? name : `${name}, mean of the elements at the node`;
    this.picked.field = chosen.values.map(at);
    chart(this.node, what, parameter, name, values, [{ name, ys: this.picked.field }]);
  }

  /** Values of the present state at the node that was picked. */
  tellValues() {
    const { curves } = this.picked;
    this.node.lastElementChild.textContent = curves.map((c) => `${c.name} ${shortNumber(c.ys[this.instant])}`).join(", ");
  }

  save() {
    this.viewer.draw();
    this.canvas.toBlob((blob) => {
      const link = element("a", { href: URL.createObjectURL(blob), download: "shape.png" });
      link.click();
      URL.revokeObjectURL(link.href);
    });
  }
}
