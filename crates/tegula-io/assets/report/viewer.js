"use strict";
/* Shapes in three dimensions by WebGL 2: meshes of quadrilaterals and lines, coloured by a field. */

/** Time between two pictures below which the shape counts as moving (ms). */
const PAUSE = 400;
/** Time between two pictures of a moving shape above which its next pictures have fewer pixels (ms), and the number of pictures that it is the mean of. */
const [SLOW, PICTURES] = [45, 6];

/** Colours of the pictures: the palette of series, and viridis. */
const COLOURS = JSON.parse(document.getElementById("colours").textContent);
/** Colour maps: colours at equal distances, as hexadecimal numbers. Both are readable by colour-blind people. */
const MAPS = {
  viridis: COLOURS.viridis.map((code) => parseInt(code.slice(1), 16)),
  // blue over light grey to orange, for values of both signs
  diverging: [0x08519c, 0x3182bd, 0x6baed6, 0xb3cde3, 0xececec, 0xfdd0a2, 0xfd8d3c, 0xd94801, 0x8c2d04],
};
const GREY = [0.72, 0.74, 0.77];

const SURFACE = {
  vertex: `#version 300 es
    uniform mat4 camera; in vec3 position; in float value; in vec4 heights;
    out vec3 place; out float shade; out vec4 height;
    void main() { place = position; shade = value; height = heights; gl_Position = camera * vec4(position, 1.0); }`,
  fragment: `#version 300 es
    precision highp float;
    uniform sampler2D map; uniform vec3 eye; uniform vec3 plain; uniform bool coloured; uniform bool sided; uniform vec3 front; uniform vec3 back;
    uniform float ratio; uniform bool edges;
    in vec3 place; in float shade; in vec4 height; out vec4 colour;
    // A line is one pixel of the page wide, half of it in each of the two elements that share it. Where an element is less than 16 pixels high above
    // one of its edges, this edge is fainter; below 6 pixels it is left out, since the lines would cover the faces.
    float line() {
      vec4 dx = dFdx(height), dy = dFdy(height), per = sqrt(dx * dx + dy * dy) + 1e-9;
      vec4 size = 1.0 / (per * ratio), near = height / per;
      vec4 ink = clamp(0.5 * max(ratio, 1.0) + 0.5 - near, 0.0, 1.0) * smoothstep(6.0, 16.0, size);
      return max(max(ink.x, ink.y), max(ink.z, ink.w));
    }
    void main() {
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      vec3 view = normalize(eye - place);
      float light = 0.55 + 0.45 * abs(dot(normal, view));
      bool missing = isnan(shade) || isinf(shade);
      vec3 base = coloured && !missing ? texture(map, vec2(clamp(shade, 0.0, 1.0), 0.5)).rgb : plain;
      if (sided) base = gl_FrontFacing ? front : back;
      colour = vec4(base * light, 1.0);
      if (edges) colour.rgb = mix(colour.rgb, vec3(0.12, 0.13, 0.15), 0.85 * line());
    }`,
};
const LINE = {
  vertex: `#version 300 es
    uniform mat4 camera; uniform vec2 aside; in vec3 position;
    void main() {
      gl_Position = camera * vec4(position, 1.0);
      gl_Position.z -= 2e-4 * gl_Position.w;
      gl_Position.xy += aside * gl_Position.w;
    }`,
  fragment: `#version 300 es
    precision highp float; uniform vec4 ink; out vec4 colour;
    void main() { colour = ink; }`,
};

/** Markers of points: square, circle, diamond, triangle, cross, each with a white rim. */
const MARKER = {
  vertex: `#version 300 es
    uniform mat4 camera; uniform float size; in vec3 position;
    void main() { gl_Position = camera * vec4(position, 1.0); gl_Position.z -= 4e-4 * gl_Position.w; gl_PointSize = size; }`,
  fragment: `#version 300 es
    precision highp float; uniform vec4 ink; uniform int symbol; out vec4 colour;
    void main() {
      vec2 p = 2.0 * gl_PointCoord - 1.0, a = abs(p);
      float d = symbol == 0 ? max(a.x, a.y) / 0.85
        : symbol == 1 ? length(p)
        : symbol == 2 ? a.x + a.y
        : symbol == 3 ? max(2.0 * p.y, 1.73 * a.x - p.y)
        : min(max(3.0 * a.x, a.y), max(a.x, 3.0 * a.y));
      if (d > 1.0) discard;
      colour = d > 0.75 ? vec4(1.0, 1.0, 1.0, ink.a) : ink;
    }`,
};
/** Colours of the side of the directors and of the other side. */
const SIDES = [[0.55, 0.74, 0.9], [0.93, 0.67, 0.42]];

/** Colour of a map at t between 0 and 1, channels 0 to 255. */
function colourAt(map, t) {
  const at = t * (map.length - 1), i = Math.min(Math.floor(at), map.length - 2), w = at - i;
  return [16, 8, 0].map((s) => Math.round(((map[i] >> s) & 255) * (1 - w) + ((map[i + 1] >> s) & 255) * w));
}

/** Product of matrices stored by columns. */
function times(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c++)
    for (let r = 0; r < 4; r++)
      for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}

/**
 * Heights of the corners of a cell above its four edges, 255 at the corners that an edge does not touch. Triangles are quadrilaterals with two equal
 * corners, whose edge of no length is nowhere drawn.
 */
function heightsOf(corners) {
  const out = new Array(16).fill(0), has = (e, p) => corners[e] === p || corners[(e + 1) & 3] === p;
  for (let e = 0; e < 4; e++)
    for (let c = 0; c < 4; c++) out[4 * c + e] = corners[e] === corners[(e + 1) & 3] || !has(e, corners[c]) ? 255 : 0;
  return out;
}

/** Whether the graphics are drawn by the processor. */
function drawnBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl2"), more = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl ? String(gl.getParameter(more ? more.UNMASKED_RENDERER_WEBGL : gl.RENDERER)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** A mesh on the graphics card. Each cell has corners of its own, so that values of cells end at its edges. */
class DrawnMesh {
  constructor(gl, mesh) {
    this.gl = gl;
    this.mesh = mesh;
    const { quads, lines } = mesh, nq = quads.length / 4, nl = lines.length / 2;
    this.count = 4 * nq + 2 * nl;
    this.node = new Uint32Array(this.count);
    this.cell = new Uint32Array(this.count);
    this.node.set(quads);
    this.node.set(lines, 4 * nq);
    for (let i = 0; i < this.count; i++) this.cell[i] = i < 4 * nq ? i >> 2 : nq + ((i - 4 * nq) >> 1);
    const triangles = new Uint32Array(6 * nq), heights = new Uint8Array(4 * this.count), seen = new Map();
    for (let q = 0; q < nq; q++) {
      const v = 4 * q;
      triangles.set([v, v + 1, v + 2, v, v + 2, v + 3], 6 * q);
      heights.set(heightsOf(quads.subarray(v, v + 4)), 4 * v);
      for (let e = 0; e < 4; e++) {
        const a = quads[v + e], b = quads[v + ((e + 1) & 3)];
        if (a === b) continue;
        const key = Math.min(a, b) * mesh.points + Math.max(a, b), number = seen.get(key) || 0;
        seen.set(key, number + 1);
      }
    }
    const ends = Uint32Array.from({ length: 2 * nl }, (_, l) => 4 * nq + l);
    const rim = [];
    for (const [key, number] of seen) if (number === 1) rim.push(Math.floor(key / mesh.points), key % mesh.points);
    this.positions = new Float32Array(3 * this.count);
    this.values = new Float32Array(this.count);
    this.moved = new Float32Array(3 * mesh.points);
    this.buffers = {
      positions: gl.createBuffer(), values: gl.createBuffer(), reference: gl.createBuffer(),
      heights: gl.createBuffer(), triangles: this.indices(triangles), lines: this.indices(ends), rim: this.indices(new Uint32Array(rim)),
    };
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.heights);
    gl.bufferData(gl.ARRAY_BUFFER, heights, gl.STATIC_DRAW);
    this.sizes = { triangles: 6 * nq, lines: 2 * nl, rim: rim.length };
  }

  indices(data) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  /** Moves the points from a reference by the sum of shapes, each a list of displacements along x, y and z with its factor. */
  move(reference, shapes) {
    const { mesh, moved, node, positions, gl } = this;
    if (reference !== this.reference) {
      this.reference = reference;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.reference);
      gl.bufferData(gl.ARRAY_BUFFER, reference, gl.STATIC_DRAW);
    }
    moved.set(reference);
    for (const [shape, factor] of shapes)
      for (let c = 0; c < 3; c++) {
        const u = shape[c];
        for (let i = 0; i < mesh.points; i++) moved[3 * i + c] += factor * u[i];
      }
    for (let i = 0; i < this.count; i++)
      for (let c = 0; c < 3; c++) positions[3 * i + c] = moved[3 * node[i] + c];
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.positions);
    gl.bufferData(gl.ARRAY_BUFFER, positions, gl.DYNAMIC_DRAW);
  }

  /** Colours by values at the points or of the cells, by their places in a range; by one colour without values. */
  colour(values, atPoints, [low, high] = [0, 1]) {
    const { gl } = this;
    this.coloured = Boolean(values);
    if (values) {
      const index = atPoints ? this.node : this.cell;
      // The range may be beyond single precision, and its size beyond double precision.
      const size = high / 2 - low / 2;
      for (let i = 0; i < this.count; i++) {
        const value = values[index[i]];
        this.values[i] = size > 0 || Number.isNaN(value) ? (value / 2 - low / 2) / size : 0.5;
      }
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.values);
    gl.bufferData(gl.ARRAY_BUFFER, this.values, gl.DYNAMIC_DRAW);
  }
}

/** Camera, pointer and drawing. */
class Viewer {
  constructor(canvas) {
    this.canvas = canvas;
    // Software smooths still pictures by twice as many pixels each way, since smoothing by the graphics doubles the cost of each picture that moves.
    this.software = drawnBySoftware();
    const gl = (this.gl = canvas.getContext("webgl2", { antialias: !this.software, alpha: false }));
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.surface = this.program(SURFACE);
    this.line = this.program(LINE);
    this.marker = this.program(MARKER);
    this.marks = [];
    this.sided = false;
    this.texture = gl.createTexture();
    this.meshes = [];
    this.range = [0, 1];
    this.show = { edges: true, undeformed: true };
    this.view = { azimuth: -60, elevation: 25, distance: 1, target: [0, 0, 0], size: 1 };
    this.home = null;
    this.onpick = () => {};
    this.ondraw = () => {};
    [this.playing, this.slow, this.before, this.gaps] = [false, this.software, -Infinity, []];
    this.map("viridis");
    this.listen();
    this.box = canvas.getBoundingClientRect();
    new ResizeObserver(() => {
      this.box = canvas.getBoundingClientRect();
      this.redraw();
    }).observe(canvas);
  }

  program(source) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, source.vertex], [gl.FRAGMENT_SHADER, source.fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "position");
    gl.bindAttribLocation(program, 1, "value");
    gl.bindAttribLocation(program, 2, "heights");
    gl.linkProgram(program);
    const places = new Map();
    return { program, at: (name) => places.get(name) ?? places.set(name, gl.getUniformLocation(program, name)).get(name) };
  }

  /** Chooses a colour map. */
  map(name) {
    this.paint((t) => colourAt(MAPS[name], t));
  }

  /** Colours the places from 0 to 1 of a range. */
  paint(colour) {
    const gl = this.gl, pixels = new Uint8Array(4 * 256);
    for (let i = 0; i < 256; i++) pixels.set([...colour(i / 255), 255], 4 * i);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
    this.redraw();
  }

  /** Shows other meshes. */
  load(meshes) {
    for (const drawn of this.meshes) Object.values(drawn.buffers).forEach((b) => this.gl.deleteBuffer(b));
    this.meshes = meshes.map((mesh) => new DrawnMesh(this.gl, mesh));
  }

  /** Looks at a box from the first direction. */
  fit(low, high) {
    const size = Math.hypot(...high.map((h, i) => h - low[i])) || 1;
    const target = high.map((h, i) => (h + low[i]) / 2);
    const { width, height } = this.canvas.getBoundingClientRect();
    const narrow = Math.min(1, (width || 1) / (height || 1));
    this.home = { azimuth: -60, elevation: 25, distance: (1.75 * size) / Math.max(narrow, 0.3), target, size };
    this.reset();
  }

  reset() {
    this.view = { ...this.home, target: [...this.home.target] };
    this.redraw();
  }

  /** Directions to the right, upwards and towards the viewer. */
  axes() {
    const [a, e] = [this.view.azimuth, this.view.elevation].map((x) => (x * Math.PI) / 180);
    const [sa, ca, se, ce] = [Math.sin(a), Math.cos(a), Math.sin(e), Math.cos(e)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], near: [ce * ca, ce * sa, se] };
  }

  eye() {
    const { near } = this.axes();
    return this.view.target.map((x, i) => x + this.view.distance * near[i]);
  }

  camera() {
    const { right, up, near } = this.axes(), eye = this.eye(), { width, height } = this.canvas;
    const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    const look = new Float32Array([right[0], up[0], near[0], 0, right[1], up[1], near[1], 0, right[2], up[2], near[2], 0, dot(right), dot(up), dot(near), 1]);
    const f = 1 / Math.tan((16 * Math.PI) / 180), { distance, size } = this.view;
    const far = distance + 3 * size, close = Math.max(distance - 3 * size, distance / 100);
    const lens = new Float32Array([(f * height) / width, 0, 0, 0, 0, f, 0, 0, 0, 0, -(far + close) / (far - close), -1, 0, 0, (-2 * far * close) / (far - close), 0]);
    return times(lens, look);
  }

  /** Draws at the next turn of the page; while pictures follow one another, those before the last one have fewer pixels where drawing is slow. */
  redraw() {
    if (this.due) return;
    this.due = requestAnimationFrame((now) => {
      const gap = now - this.before, moving = this.playing || gap < PAUSE;
      this.due = 0;
      this.before = now;
      if (gap < PAUSE) this.adapt(gap);
      clearTimeout(this.rest);
      this.draw(moving);
      if (moving) this.rest = setTimeout(() => this.draw(), PAUSE);
    });
  }

  /** Finds out by the times between the pictures of a moving shape whether drawing is slow. */
  adapt(gap) {
    this.gaps.push(gap);
    if (this.gaps.length < PICTURES) return;
    this.slow ||= this.gaps.reduce((a, b) => a + b) > PICTURES * SLOW;
    this.gaps = [];
  }

  /** Pixels of the canvas for each pixel of the page. With less than one the browser enlarges each picture, which takes longer than to draw it. */
  ratio(moving) {
    const own = Math.min(window.devicePixelRatio || 1, 2);
    if (moving) return this.slow ? Math.min(own, 1) : own;
    return this.software ? 2 : own;
  }

  draw(moving = false) {
    const { gl, canvas, box } = this, ratio = this.ratio(moving);
    const [w, h] = [Math.max(1, Math.round(box.width * ratio)), Math.max(1, Math.round(box.height * ratio))];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const camera = this.camera();
    gl.useProgram(this.surface.program);
    gl.uniformMatrix4fv(this.surface.at("camera"), false, camera);
    gl.uniform3fv(this.surface.at("eye"), this.eye());
    gl.uniform3fv(this.surface.at("plain"), GREY);
    gl.uniform3fv(this.surface.at("front"), SIDES[0]);
    gl.uniform3fv(this.surface.at("back"), SIDES[1]);
    gl.uniform1f(this.surface.at("ratio"), ratio);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    for (const drawn of this.meshes) {
      gl.uniform1i(this.surface.at("coloured"), drawn.coloured ? 1 : 0);
      gl.uniform1i(this.surface.at("edges"), this.show.edges && !drawn.mesh.outline ? 1 : 0);
      gl.uniform1i(this.surface.at("sided"), this.sided && !drawn.mesh.outline ? 1 : 0);
      this.bind(0, drawn.buffers.positions, 3);
      this.bind(1, drawn.buffers.values, 1);
      this.bind(2, drawn.buffers.heights, 4, gl.UNSIGNED_BYTE);
      this.elements(gl.TRIANGLES, drawn.buffers.triangles, drawn.sizes.triangles);
    }
    gl.disableVertexAttribArray(1);
    gl.disableVertexAttribArray(2);
    gl.useProgram(this.line.program);
    gl.uniformMatrix4fv(this.line.at("camera"), false, camera);
    for (const drawn of this.meshes) {
      const { lines, rim } = drawn.sizes;
      this.bind(0, drawn.buffers.positions, 3);
      if (lines) this.strokes([0.24, 0.29, 0.36, 1], 1, [w, h], ratio, () => this.elements(gl.LINES, drawn.buffers.lines, lines));
      if (!this.show.undeformed || drawn.mesh.outline) continue;
      this.bind(0, drawn.buffers.reference, 3);
      this.strokes([0.55, 0.57, 0.6, 1], ratio > 1 ? 0.25 : 0, [w, h], ratio, () => this.elements(gl.LINES, drawn.buffers.rim, rim));
    }
    if (this.marks.length) this.drawMarks(camera, [w, h], ratio);
    this.frames = (this.frames || 0) + 1;
    this.ondraw();
  }

  /** Draws lines several times beside each other, since those of WebGL are one pixel wide; `apart` is their distance in pixels of the page. */
  strokes(ink, apart, [w, h], ratio, draw) {
    const { gl } = this;
    gl.uniform4f(this.line.at("ink"), ...ink);
    for (const [x, y] of apart ? [[0, 0], [apart, 0], [-apart, 0], [0, apart], [0, -apart]] : [[0, 0]]) {
      gl.uniform2f(this.line.at("aside"), (2 * x * ratio) / w, (2 * y * ratio) / h);
      draw();
    }
  }

  /** A mark on the graphics card: points, ends of lines and corners of triangles, as lists of coordinates. */
  mark({ colour, symbol, size, points, lines, faces }) {
    const gl = this.gl, out = { on: true, colour, symbol, size };
    for (const [name, coordinates] of Object.entries({ points, lines, faces })) {
      out[name] = { buffer: gl.createBuffer(), count: coordinates.length / 3 };
      gl.bindBuffer(gl.ARRAY_BUFFER, out[name].buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(coordinates), gl.STATIC_DRAW);
    }
    return out;
  }

  /** Draws the marks; those behind a surface show faintly through it. */
  drawMarks(camera, [w, h], ratio) {
    const { gl } = this, draw = (part, mode) => {
      if (!part.count) return;
      this.bind(0, part.buffer, 3);
      gl.drawArrays(mode, 0, part.count);
    };
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.line.program);
    gl.uniformMatrix4fv(this.line.at("camera"), false, camera);
    for (const { colour, faces } of this.marks) {
      gl.uniform4f(this.line.at("ink"), ...colour, 0.6);
      gl.uniform2f(this.line.at("aside"), 0, 0);
      draw(faces, gl.TRIANGLES);
    }
    for (const [hidden, opacity] of [[true, 0.12], [false, 1]]) {
      if (hidden) gl.disable(gl.DEPTH_TEST);
      else gl.enable(gl.DEPTH_TEST);
      gl.useProgram(this.line.program);
      for (const { colour, lines } of this.marks)
        this.strokes([...colour, opacity], 0.7, [w, h], ratio, () => draw(lines, gl.LINES));
      gl.useProgram(this.marker.program);
      gl.uniformMatrix4fv(this.marker.at("camera"), false, camera);
      for (const { colour, symbol, size, points } of this.marks) {
        gl.uniform4f(this.marker.at("ink"), ...colour, opacity);
        gl.uniform1i(this.marker.at("symbol"), symbol);
        gl.uniform1f(this.marker.at("size"), size * ratio);
        draw(points, gl.POINTS);
      }
    }
    gl.disable(gl.BLEND);
  }

  bind(place, buffer, size, type = this.gl.FLOAT) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, type !== gl.FLOAT, 0, 0);
  }

  elements(mode, buffer, count) {
    if (!count) return;
    this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER, buffer);
    this.gl.drawElements(mode, count, this.gl.UNSIGNED_INT, 0);
  }

  /** Places of the points of a mesh on the canvas, with their distances; those behind the viewer have none. */
  project({ mesh, moved }) {
    const m = this.camera(), box = this.canvas.getBoundingClientRect(), out = new Float32Array(3 * mesh.points);
    for (let i = 0; i < mesh.points; i++) {
      const [x, y, z] = moved.subarray(3 * i, 3 * i + 3);
      const [a, b, w] = [0, 1, 3].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]);
      out.set(w > 0 ? [(0.5 + a / w / 2) * box.width, (0.5 - b / w / 2) * box.height, w] : [NaN, NaN, NaN], 3 * i);
    }
    return out;
  }

  /** The corner nearest to a place of the canvas of the cell that is seen there; without a cell the nearest point within 14 pixels. */
  pick(px, py) {
    let hit = null, near = null;
    this.meshes.forEach((drawn, mesh) => {
      if (drawn.mesh.outline) return;
      const at = this.project(drawn), { quads } = drawn.mesh;
      const apart = (p) => Math.hypot(at[3 * p] - px, at[3 * p + 1] - py);
      for (let q = 0; q < quads.length; q += 4)
        for (const corners of [[quads[q], quads[q + 1], quads[q + 2]], [quads[q], quads[q + 2], quads[q + 3]]]) {
          const [[ax, ay, aw], [bx, by, bw], [cx, cy, cw]] = corners.map((p) => at.subarray(3 * p, 3 * p + 3));
          const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
          const u = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area, v = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area;
          if (!(u >= 0 && v >= 0 && u + v <= 1)) continue;
          const depth = 1 / ((1 - u - v) / aw + u / bw + v / cw);
          if (!hit || depth < hit.depth) {
            const point = [...quads.subarray(q, q + 4)].reduce((a, p) => (apart(p) < apart(a) ? p : a));
            hit = { depth, mesh, point };
          }
        }
      for (let p = 0; p < drawn.mesh.points; p++)
        if (apart(p) < (near ? near.distance : 14)) near = { distance: apart(p), mesh, point: p };
    });
    return hit || near;
  }

  listen() {
    const { canvas } = this, pointers = new Map();
    let moved = 0, spread = 0;
    const place = (e) => [e.clientX, e.clientY];
    const distance = () => {
      const [a, b] = [...pointers.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, place(e));
      moved = 0;
      if (pointers.size === 2) spread = distance();
    });
    canvas.addEventListener("pointermove", (e) => {
      const before = pointers.get(e.pointerId);
      if (!before) return;
      const [dx, dy] = [e.clientX - before[0], e.clientY - before[1]];
      pointers.set(e.pointerId, place(e));
      moved += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        const now = distance();
        this.zoom(spread / (now || 1));
        spread = now;
        this.pan(dx / 2, dy / 2);
      } else if (e.shiftKey || e.buttons & 6) this.pan(dx, dy);
      else this.turn(-0.4 * dx, 0.4 * dy);
    });
    const up = (e) => {
      if (pointers.delete(e.pointerId) && moved < 5 && e.type === "pointerup") {
        const box = canvas.getBoundingClientRect();
        const found = this.pick(e.clientX - box.left, e.clientY - box.top);
        if (found) this.onpick(found);
      }
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, 0.0015 * e.deltaY))));
    }, { passive: false });
  }

  turn(right, up) {
    this.view.azimuth += right;
    this.view.elevation = Math.max(-89.9, Math.min(89.9, this.view.elevation + up));
    this.redraw();
  }

  zoom(factor) {
    const { home } = this;
    if (!home) return;
    this.view.distance = Math.max(0.02 * home.size, Math.min(20 * home.distance, this.view.distance * factor));
    this.redraw();
  }

  pan(dx, dy) {
    const { right, up } = this.axes(), { height } = this.canvas.getBoundingClientRect();
    const scale = (2 * Math.tan((16 * Math.PI) / 180) * this.view.distance) / (height || 1);
    this.view.target = this.view.target.map((x, i) => x + scale * (dy * up[i] - dx * right[i]));
    this.redraw();
  }
}
