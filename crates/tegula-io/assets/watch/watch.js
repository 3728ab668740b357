"use strict";
/* The page of a run that goes on: fetches twice per second what is new, and shows shape, curves, progress and messages. */

/** Time between two requests (ms). */
const PERIOD = 500;
/** Number of requests that may fail one after another before the run counts as gone. */
const MOST_FAILURES = 3;
/** Number of rows beyond which those that are evenly spaced are fetched again. */
const MOST_ROWS = 9000;
/** Displacements, as a part of the model, below which they are shown larger. */
const SMALL = 0.02;

/** Fetches content of the run. */
async function fetched(name) {
  const answer = await fetch(name, { cache: "no-store", signal: AbortSignal.timeout(30000) });
  if (!answer.ok) throw new Error(`the run answers with ${answer.status}`);
  return answer;
}

/** Meshes of the present analysis, with the displacements and stresses of one state. */
class LiveShapes extends Shapes {
  /** Reads the reference configuration, whose parts are described in `watch/shapes.rs`. */
  static of(buffer) {
    const words = new Uint32Array(buffer), out = new LiveShapes();
    out.scene = { kind: "states", parameter: "at", values: [0], labels: ["reference configuration"] };
    [out.part, out.instants, out.shown, out.meshes, out.cache] = [words[0], 1, [0], [], new Map()];
    let at = 2;
    const take = (Type, count) => new Type(buffer, 4 * (at += count) - 4 * count, count);
    for (let m = 0; m < words[1]; m++) {
      const [outline, points, quads, lines] = take(Uint32Array, 4);
      if (outline !== 1) out.stress = new Float32Array(quads).fill(NaN);
      out.meshes.push({
        outline: outline === 1, points, fields: outline === 1 ? [] : [{ name: "von_mises", components: [[""]] }],
        references: [take(Float32Array, 3 * points)], quads: take(Uint32Array, 4 * quads), lines: take(Uint32Array, 2 * lines),
        displacement: [[0, 1, 2].map(() => new Float32Array(points))],
      });
    }
    return out;
  }

  async decode(choice) {
    return choice === "von_mises/" ? { atPoints: false, values: [this.stress] } : super.decode(choice);
  }

  /** Takes the displacements and stresses of another state; false if they belong to another analysis. */
  renew(buffer, parameter) {
    const words = new Uint32Array(buffer), numbers = new Float32Array(buffer);
    if (!words.length || words[0] !== this.part) return false;
    [this.number, this.scene.labels[0]] = [words[1], `${parameter} ${shortNumber(Number(numbers[2].toPrecision(6)))}`];
    let at = 3;
    for (const { points, displacement: [u] } of this.meshes)
      for (let i = 0; i < points; i++) for (let c = 0; c < 3; c++) u[c][i] = numbers[at++];
    this.stress?.set(numbers.subarray(at, at + this.stress.length));
    this.cache.clear();
    return true;
  }
}

/** The shape of a run that goes on. */
class LiveStage extends Stage {
  constructor(holder) {
    super(holder, []);
    this.slider.hidden = this.play.hidden = this.each.parentElement.hidden = true;
    this.ofMotion[3].textContent = " Keys: + − scale.";
    this.invitation.textContent = "Click on a shell to see the displacement at its nearest node.";
    this.scale.addEventListener("input", () => (this.chosenScale = true));
  }

  /** Shows the meshes of another analysis; the view stays where it is of the same model. */
  async begin(shapes) {
    const before = this.box, { view, home } = this.viewer, kept = this.scale.value;
    this.clicked = null;
    await this.present(shapes);
    this.each.value = "one";
    this.scaled = false;
    if (before && [0, 1, 2].every((c) => before.low[c] === this.box.low[c] && before.high[c] === this.box.high[c])) {
      [this.viewer.view, this.viewer.home] = [view, home];
      if (this.chosenScale) this.scale.value = kept;
    } else [this.chosenScale, this.seen] = [false, { low: [...this.box.low], high: [...this.box.high] }];
    await this.recolour();
  }

  /** Shows the shape that has come, that of a part of the analysis. */
  async renew(done) {
    const { box, shapes } = this, { largest } = shapes.extent();
    box.largest = largest;
    this.rescale(largest[0], done);
    this.follow();
    await this.recolour();
    if (this.clicked) super.pick(this.clicked);
  }

  /** Enlarges small displacements when a tenth of the analysis is done, and less when they grow, until the user has chosen a scale. */
  rescale(largest, done) {
    if (this.chosenScale || !(largest > 0) || done < 0.1) return;
    const { size } = this.box, scale = Number(this.scale.value);
    if (this.scaled && scale * largest < 0.25 * size) return;
    const wanted = largest < SMALL * size ? rounded125((0.1 * size) / largest) : 1;
    this.scale.value = this.scaled ? Math.min(scale, wanted) : wanted;
    this.scaled = true;
  }

  /** Looks from further away at a shape that has left the view, unless the user has turned it. */
  follow() {
    const { viewer, seen } = this, [low, high] = this.swept();
    const size = Math.hypot(...seen.high.map((h, i) => h - seen.low[i])) || 1;
    if (!low.some((x, c) => x < seen.low[c] - 0.02 * size || high[c] > seen.high[c] + 0.02 * size)) return;
    this.seen = { low: low.map((x, c) => Math.min(x, seen.low[c])), high: high.map((x, c) => Math.max(x, seen.high[c])) };
    const { azimuth, elevation, distance, target } = viewer.view, { home } = viewer;
    const still = distance === home.distance && target.every((x, c) => x === home.target[c]);
    viewer.fit(this.seen.low, this.seen.high);
    Object.assign(viewer.view, still ? { azimuth, elevation } : { azimuth, elevation, distance, target });
  }

  pick(found) {
    this.clicked = found;
    super.pick(found);
  }

  key(e) {
    if (["+", "-", "r"].includes(e.key)) super.key(e);
    if (["+", "-"].includes(e.key)) this.chosenScale = true;
  }
}

/** Curves of the present analysis, which grow. */
class LiveCurves {
  constructor(holder, { analysis, columns }) {
    [this.holder, this.names, this.columns] = [holder, columns, columns.map(() => [])];
    this.dynamic = analysis === "transient";
    this.parameter = this.dynamic ? "time" : "load factor";
    this.plots = new Map();
    holder.replaceChildren();
  }

  of(name) {
    return this.columns[this.names.indexOf(name)];
  }

  get rows() {
    return this.columns.length ? this.columns[0].length : 0;
  }

  /** Appends rows, one behind the other. */
  append(values) {
    const width = this.names.length;
    values.forEach((v, i) => this.columns[i % width].push(v === null ? NaN : v));
    if (values.length) this.draw();
  }

  clear() {
    for (const column of this.columns) column.length = 0;
  }

  /** Shows curves in the plot of a title, which is made anew where their names have changed. */
  plot(title, curves, make, renew) {
    const names = curves.map((c) => c.name).join("\n"), known = this.plots.get(title);
    if (!curves.length) return;
    if (known && known.names === names) return renew(known, curves);
    const place = known?.place || element("div");
    if (!known) this.holder.append(place);
    known?.plot.destroy();
    place.replaceChildren();
    this.plots.set(title, { names, place, curves, plot: make(place, curves) });
  }

  /** Curves over the time or load factor. */
  chart(title, y, x, xs, curves) {
    this.plot(title, curves, (place) => chart(place, title, x, y, xs, curves), ({ plot }) => plot.renew(xs, curves));
  }

  draw() {
    const { parameter } = this, first = this.columns[0], position = this.of("path.position");
    const size = (n) => this.of(n).reduce((a, v) => Math.max(a, Math.abs(v) || 0), 0);
    const points = [...new Set(this.names.filter((n) => /\.u[xyz]$/.test(n)).map((n) => n.slice(0, -3)))];
    const named = (names) => names.filter((n) => this.of(n)).map((n) => ({ name: n, ys: this.of(n) }));
    if (this.dynamic)
      for (const point of points.slice(0, 2))
        this.chart(`displacement of ${point}`, "displacement", parameter, first, ["ux", "uy", "uz"].map((c) => ({ name: c, ys: this.of(`${point}.${c}`) })));
    else this.loads(points.flatMap((p) => ["ux", "uy", "uz"].map((c) => `${p}.${c}`)), size, position);
    const [x, xs] = position ? ["position on the path", position] : [parameter, first];
    this.chart("energies", "energy", x, xs, named(this.dynamic ? ["kinetic", "strain", "total"] : ["strain", "total"]));
    this.chart(this.dynamic ? "step size" : "increment of the load factor", "step size", x, xs, named(["step_size"]).map((c) => ({ ...c, name: "step size" })));
  }

  /** Load factor over the displacements that are not round-off. */
  loads(names, size, position) {
    const largest = Math.max(0, ...names.map(size)), moving = names.filter((n) => largest > 0 && size(n) > 1e-6 * largest).slice(0, 7);
    const unstable = this.of("path.negative_eigenvalues"), dashed = unstable && unstable.map((n) => n > 0);
    const curves = moving.map((n) => ({ name: n, xs: this.of(n), ys: this.columns[0], dashed }));
    const title = position ? "equilibrium path (dashed: negative eigenvalues)" : "load factor over displacement";
    this.plot(title, curves, (place, own) => diagram(place, title, "displacement", "load factor", own), (known, own) => {
      known.curves.forEach((curve, i) => Object.assign(curve, own[i]));
      known.plot.renew();
    });
  }
}

/** The page. */
class Watch {
  constructor() {
    this.at = (id) => document.getElementById(id);
    this.known = { part: 0, row: 0, message: 0, shape: 0 };
    [this.failures, this.whole] = [0, false];
    this.at("stop").addEventListener("click", () => this.stop());
  }

  /** Fetches what is new until the run has ended and everything is here. */
  async follow() {
    while (!this.whole) {
      try {
        await this.poll();
        this.failures = 0;
      } catch (error) {
        if (++this.failures >= MOST_FAILURES) return this.lost(error);
      }
      await new Promise((done) => setTimeout(done, PERIOD));
    }
  }

  async poll() {
    const { known } = this, query = new URLSearchParams(known);
    const news = await (await fetched(`news?${query}`)).json();
    if (news.heading) await this.begin(news);
    if (this.curves && known.part === news.part) {
      if (this.curves.rows > MOST_ROWS) {
        this.curves.clear();
        known.row = 0;
      } else {
        this.curves.append(news.rows);
        known.row = news.row;
      }
    }
    this.tell(news);
    if (known.part === news.part && news.shape !== known.shape) await this.move();
    this.outcome(news);
    this.whole = news.whole;
  }

  /** Shows another analysis. */
  async begin({ heading, part }) {
    const shapes = LiveShapes.of(await (await fetched("mesh")).arrayBuffer());
    // Yet another analysis may have begun.
    if (shapes.part !== part) return;
    [this.heading, this.known.part, this.known.row, this.known.shape] = [heading, part, 0, 0];
    document.title = this.at("title").textContent = heading.title || "tegula";
    const count = (n, noun) => `${n.toLocaleString("en").replaceAll(",", " ")} ${noun}`;
    this.at("line").textContent = `${heading.described}, ${count(heading.elements, "elements")}, ${count(heading.unknowns, "unknowns")}`;
    this.at("step").textContent = "";
    this.at("bar").value = 0;
    this.curves = new LiveCurves(this.at("plots"), heading);
    this.at("curves").hidden = !heading.columns.length;
    this.at("shapes").hidden = !shapes.meshes.length;
    await this.present(shapes);
  }

  async present(shapes) {
    this.shapes = shapes;
    if (!shapes.meshes.length || this.noShapes) return;
    try {
      this.stage ??= new LiveStage(this.at("scene"));
      await this.stage.begin(shapes);
    } catch (error) {
      this.noShapes = true;
      this.at("scene").replaceChildren(element("p", { className: "warnings" }, `The shape cannot be shown: ${error.message}.`));
    }
  }

  /** Fetches the latest shape. */
  async move() {
    const buffer = await (await fetched("shape")).arrayBuffer();
    if (!this.shapes.renew(buffer, this.heading.analysis === "transient" ? "time" : "load factor")) return;
    this.known.shape = this.shapes.number;
    if (this.stage && this.shapes.meshes.length && !this.noShapes) await this.stage.renew(this.done || 0);
  }

  /** Shows progress and messages. */
  tell({ progress, messages, message }) {
    const { heading } = this, { known } = this;
    if (progress && heading) {
      const [step, time, length, iterations] = progress, dynamic = heading.analysis === "transient";
      this.done = Math.max(0, Math.min(1, (time - heading.first) / (heading.end - heading.first))) || 0;
      this.at("bar").value = this.done;
      const words = dynamic ? ["time", "step size"] : ["load factor", "increment"];
      this.at("step").textContent = `step ${step}: ${words[0]} ${shortNumber(Number(time.toPrecision(6)))}, ${words[1]} ${shortNumber(Number(length.toPrecision(3)))}, ${iterations} iteration${iterations === 1 ? "" : "s"}`;
    }
    if (known.part && this.at("status").textContent === "starting") this.status("running");
    const list = this.at("messages").querySelector("ul"), atEnd = list.scrollTop + list.clientHeight >= list.scrollHeight - 4;
    for (const { kind, text } of messages) list.append(element("li", { className: kind === "warning" ? "warnings" : "" }, kind === "warning" ? `warning: ${text}` : text));
    while (list.children.length > 200) list.firstElementChild.remove();
    this.at("messages").hidden = !list.children.length;
    if (atEnd) list.scrollTop = list.scrollHeight;
    known.message = message;
  }

  status(name, text = name) {
    const place = this.at("status");
    [place.className, place.textContent] = [`status ${name}`, text];
  }

  /** Shows how the run has ended. */
  outcome({ outcome }) {
    if (!outcome || this.ended) return;
    this.ended = true;
    this.status(outcome.status);
    if (outcome.status === "complete") this.at("bar").value = 1;
    if (outcome.text) this.at("line").textContent += `\n${outcome.text}`;
    const stop = this.at("stop");
    [stop.disabled, stop.textContent] = [true, "the run has ended"];
  }

  async stop() {
    const stop = this.at("stop");
    [stop.disabled, stop.textContent] = [true, "stopping …"];
    try {
      const answer = await fetch("stop", { method: "POST" });
      if (!answer.ok) throw new Error(`the run answers with ${answer.status}`);
    } catch (error) {
      if (this.ended) return;
      [stop.disabled, stop.textContent] = [false, "Stop the run"];
      this.at("step").textContent = `The run cannot be stopped from here: ${error.message}. Ctrl-C in its terminal stops it.`;
    }
  }

  /** Shows that the run no longer answers. */
  lost() {
    const stop = this.at("stop");
    [stop.disabled, stop.textContent] = [true, "no connection"];
    if (!this.ended) this.status("failed", "no answer");
    this.at("line").textContent += "\nThe program no longer answers: it has ended.";
  }
}

const page = new Watch();
/** The page, and the end of the run. */
window.watch = { page, ended: page.follow() };
