"use strict";
// The page: draws one pair of bodies at a time t, which the slider, the player or the URL hash sets.
// Positions are in the frame of the page (see html.py); T is a plain array of 12 numbers, a 3x4 pose by rows.
(() => {
  const DATA = JSON.parse(document.getElementById("data").textContent);
  for (const pair of DATA.pairs) for (const body of pair.bodies) for (const element of body.elements) Object.assign(element, DATA.shapes[element.shape]);
  const $ = (id) => document.getElementById(id);
  const COLOURS = ["#4f7fa8", "#d9a766"];
  const DARK = ["#1f3e5a", "#7c5217"];
  const ACCENT = "#d02f42";
  const SECONDS = 5; // one run through the window
  const DWELL = 0.9; // seconds the player rests at the contact
  const PATH_STEPS = 240;
  const STATUS = {
    CONTACT: "contact", FREE: "free", INITIAL_CONTACT: "contact at the start", UNDECIDED: "undecided",
    CURVE: "intersection", APART: "no common point",
  };

  // -- reading ----------------------------------------------------------------------------------------------

  function decode(text, Type) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Type(bytes.buffer);
  }

  // -- poses ------------------------------------------------------------------------------------------------

  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const apply = (T, p) => [0, 4, 8].map((r) => T[r] * p[0] + T[r + 1] * p[1] + T[r + 2] * p[2] + T[r + 3]);
  const turn = (T, p) => [0, 4, 8].map((r) => T[r] * p[0] + T[r + 1] * p[1] + T[r + 2] * p[2]);

  // The screw that carries pose S to pose E: rotation vector w and linear part u. The turn is below pi.
  function twist(S, E) {
    const R = [];
    for (let i = 0; i < 3; i++) for (let k = 0; k < 3; k++) {
      R.push(E[4 * i] * S[4 * k] + E[4 * i + 1] * S[4 * k + 1] + E[4 * i + 2] * S[4 * k + 2]);
    }
    const d = [0, 1, 2].map((i) => E[4 * i + 3] - R[3 * i] * S[3] - R[3 * i + 1] * S[7] - R[3 * i + 2] * S[11]);
    let w = [(R[7] - R[5]) / 2, (R[2] - R[6]) / 2, (R[3] - R[1]) / 2];
    const sine = Math.hypot(...w);
    const angle = Math.atan2(sine, (R[0] + R[4] + R[8] - 1) / 2);
    if (sine > 0) w = w.map((x) => (x * angle) / sine);
    const k = angle < 1e-4 ? 1 / 12 : 1 / angle ** 2 - (1 + Math.cos(angle)) / (2 * angle * Math.sin(angle));
    const once = cross(w, d);
    const twice = cross(w, once);
    return { w, u: d.map((x, i) => x - once[i] / 2 + k * twice[i]) };
  }

  // Pose S after the given part of a screw.
  function screwed(S, { w, u }, part) {
    const v = w.map((x) => x * part);
    const l = u.map((x) => x * part);
    const angle = Math.hypot(...v);
    const small = angle < 1e-4;
    const A = small ? 1 : Math.sin(angle) / angle;
    const B = small ? 0.5 : (1 - Math.cos(angle)) / angle ** 2;
    const C = small ? 1 / 6 : (angle - Math.sin(angle)) / angle ** 3;
    const mix = (p, f, g) => {
      const once = cross(v, p);
      const twice = cross(v, once);
      return p.map((x, i) => x + f * once[i] + g * twice[i]);
    };
    const columns = [0, 1, 2, 3].map((k) => mix([S[k], S[4 + k], S[8 + k]], A, B));
    const shift = mix(l, B, C);
    return [0, 1, 2].flatMap((i) => [columns[0][i], columns[1][i], columns[2][i], columns[3][i] + shift[i]]);
  }

  // A body's pose as a function of time: exact at the samples, a constant-speed screw between them.
  class Motion {
    constructor(times, poses) {
      this.times = times;
      this.poses = Array.from(times, (_, k) => Array.from(poses.subarray(12 * k, 12 * k + 12)));
      this.twists = [];
    }
    at(t) {
      const { times, poses, twists } = this;
      const last = times.length - 1;
      if (!(t > times[0])) return poses[0];
      if (t >= times[last]) return poses[last];
      let lo = 0;
      let hi = last; // times[lo] <= t < times[hi]
      while (hi - lo > 1) {
        const mid = (lo + hi) >> 1;
        if (times[mid] <= t) lo = mid;
        else hi = mid;
      }
      if (times[lo] === t) return poses[lo];
      twists[lo] ??= twist(poses[lo], poses[lo + 1]);
      return screwed(poses[lo], twists[lo], (t - times[lo]) / (times[hi] - times[lo]));
    }
  }

  // -- joints -----------------------------------------------------------------------------------------------

  const CLOCKS = DATA.clocks.map((text) => decode(text, Float64Array));
  const JOINTS = DATA.joints.map((joint) => ({ ...joint, values: decode(joint.values, Float64Array) }));

  // The value of a joint at time t: a cubic of the share of the stretch that has passed.
  function valueAt(joint, t) {
    const times = CLOCKS[joint.clock];
    let lo = 0;
    let hi = times.length - 1; // times[lo] <= t < times[hi], but for the ends
    while (hi - lo > 1) {
      const mid = (lo + hi) >> 1;
      if (times[mid] <= t) lo = mid;
      else hi = mid;
    }
    const s = Math.min(Math.max((t - times[lo]) / (times[hi] - times[lo]), 0), 1);
    const [c0, c1, c2, c3] = joint.values.subarray(4 * lo, 4 * lo + 4);
    return c0 + s * (c1 + s * (c2 + s * c3));
  }

  // The pose of a link: the product of its joints, from the root outward.  frame: of the page, for joints are in the world.
  class Linked {
    constructor({ joints, home }, { origin, unit }) {
      this.home = home;
      this.chain = joints.map((k) => {
        const { axis, point, angle, way } = JOINTS[k];
        return { k, axis, point: point.map((x, i) => (x - origin[i]) / unit), angle, way: way.map((x) => x / unit) };
      });
      this.times = CLOCKS[JOINTS[joints[0]].clock];
    }
    at(t) {
      return this.with((k) => valueAt(JOINTS[k], t));
    }
    // valueOf: of a joint by its number
    with(valueOf) {
      const [x, y, z] = this.home;
      let T = [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z];
      for (const { k, axis, point, angle, way } of [...this.chain].reverse()) T = advanced(T, axis, point, angle, way, valueOf(k));
      return T;
    }
  }

  // Pose T after a joint's turn and shift by a value.
  function advanced(T, axis, point, angle, way, value) {
    const [sine, versine] = [Math.sin(angle * value), 1 - Math.cos(angle * value)];
    const turned = (p) => {
      const once = cross(axis, p);
      const twice = cross(axis, once);
      return p.map((x, i) => x + sine * once[i] + versine * twice[i]);
    };
    const columns = [0, 1, 2].map((k) => turned([T[k], T[4 + k], T[8 + k]]));
    const place = turned([T[3], T[7], T[11]].map((x, i) => x - point[i]));
    return [0, 1, 2].flatMap((i) => [columns[0][i], columns[1][i], columns[2][i], place[i] + point[i] + value * way[i]]);
  }

  const motionOf = (body, frame) => (body.joints ? new Linked(body, frame)
    : new Motion(decode(body.times, Float64Array), decode(body.poses, Float64Array)));

  // -- scene objects ----------------------------------------------------------------------------------------

  const named = (object, name, order = 0) => {
    object.name = name;
    object.renderOrder = order;
    return object;
  };

  function geometryOf(index) {
    const mesh = DATA.meshes[index];
    if (!mesh.surface) {
      const Index = mesh.wide ? Uint32Array : Uint16Array;
      const position = new THREE.BufferAttribute(decode(mesh.vertices, Float32Array), 3);
      const indexed = (text) => {
        const g = new THREE.BufferGeometry();
        g.setAttribute("position", position);
        g.setIndex(new THREE.BufferAttribute(decode(text, Index), 1));
        return g;
      };
      mesh.surface = indexed(mesh.triangles);
      if (mesh.normals) mesh.surface.setAttribute("normal", new THREE.BufferAttribute(decode(mesh.normals, Float32Array), 3));
      mesh.outline = indexed(mesh.lines);
      if (mesh.frames) {
        mesh.frameTimes = decode(mesh.frameTimes, Float64Array);
        mesh.frames = decode(mesh.frames, Float32Array);
      }
    }
    return mesh;
  }

  // The vertices of a body that deforms, at time t: blended between the two frames beside it.
  function deform(mesh, t) {
    const { frameTimes: times, frames, surface, outline } = mesh;
    const last = times.length - 1;
    let k = times.findIndex((time) => time > t) - 1; // times[k] <= t < times[k + 1]
    if (k < 0) k = t < times[0] ? 0 : Math.max(last - 1, 0);
    const next = Math.min(k + 1, last);
    const part = next > k ? Math.min(Math.max((t - times[k]) / (times[next] - times[k]), 0), 1) : 0;
    const position = surface.getAttribute("position");
    const size = position.array.length;
    for (let i = 0; i < size; i++) {
      const here = frames[k * size + i];
      position.array[i] = here + part * (frames[next * size + i] - here);
    }
    position.needsUpdate = true;
    surface.boundingSphere = outline.boundingSphere = null;
  }

  function fatLines(positions, colour, width, options = {}) {
    const geometry = new THREE.LineSegmentsGeometry();
    geometry.setPositions(positions);
    return new THREE.LineSegments2(geometry, new THREE.LineMaterial({ color: colour, linewidth: width, ...options }));
  }

  // Everything of one body: surface, sharp edges, and corners when it has no faces.
  function bodyObject(body, which, name) {
    const { surface, outline, normals } = geometryOf(body.mesh);
    const group = new THREE.Group();
    const hasFaces = surface.index.count > 0;
    const hasLines = outline.index.count > 0;
    if (hasFaces) {
      group.add(named(new THREE.Mesh(surface, new THREE.MeshLambertMaterial({
        color: COLOURS[which], flatShading: !normals, side: THREE.DoubleSide,
        ...(isCurve() ? { transparent: true, opacity: 0.5, depthWrite: false } : {}), // the curve lies in both
        // behind the edges; and where faces of both bodies coincide, a is drawn rather than a patchwork
        polygonOffset: true, polygonOffsetFactor: 1 + which, polygonOffsetUnits: 1 + 2 * which,
      })), `${name} surface`));
    }
    if (hasLines) {
      group.add(named(new THREE.LineSegments(outline, new THREE.LineBasicMaterial({
        color: hasFaces ? DARK[which] : COLOURS[which], transparent: hasFaces, opacity: hasFaces ? 0.55 : 1,
      })), `${name} edges`));
    }
    if (!hasFaces) {
      const material = new THREE.PointsMaterial({ color: COLOURS[which], size: 6, sizeAttenuation: false });
      group.add(named(new THREE.Points(surface, material), `${name} points`));
      group.children.at(-1).geometry = surface.clone().setIndex(null);
    }
    return placed(named(group, `body ${name}`));
  }

  // The start pose of a moving body, faint.
  function ghostObject(body, which, name) {
    const { surface, outline } = geometryOf(body.mesh);
    const group = new THREE.Group();
    group.add(new THREE.Mesh(surface, new THREE.MeshBasicMaterial({
      color: COLOURS[which], transparent: true, opacity: 0.09, depthWrite: false, side: THREE.DoubleSide,
    })));
    group.add(new THREE.LineSegments(outline, new THREE.LineBasicMaterial({
      color: COLOURS[which], transparent: true, opacity: 0.45, depthWrite: false,
    })));
    return placed(named(group, `ghost of ${name}`, 1));
  }

  // Touched elements: solid where they are in sight, a faint shine where the bodies hide them. The reported
  // one of each body is strong; of further faces only the outline is drawn, for several may cover a body.
  // Faces are coloured near the contact alone: `near` says where that is in the body's frame, and how far.
  function elementObject(element, strong, near) {
    const group = named(new THREE.Group(), `element ${element.name}`);
    const strength = strong ? 1 : 0.55;
    const both = (make) => {
      group.add(named(make({ transparent: true, opacity: strength, depthWrite: false }), "", 4));
      group.add(named(make({ transparent: true, opacity: 0.3 * strength, depthTest: false, depthWrite: false }), "", 5));
    };
    if (element.kind === "vertex" || element.kind === "apex") group.add(dot(element.vertices, 4.5, ACCENT, 6));
    if (["edge", "directrix", "end_ruling"].includes(element.kind)) {
      const ends = near ? within(element.vertices, near) : element.vertices;
      if (ends.length) both((o) => fatLines(ends, ACCENT, strong ? 4 : 2.5, o));
    }
    if (element.kind === "face") {
      const surface = new THREE.BufferGeometry();
      surface.setAttribute("position", new THREE.BufferAttribute(new Float32Array(element.vertices), 3));
      const fill = { color: ACCENT, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 };
      if (strong && element.vertices.length) both((o) => new THREE.Mesh(surface, fading({ ...fill, ...o, opacity: 0.6 * o.opacity }, near)));
      const outline = near ? within(element.outline, near) : element.outline;
      if (outline.length) both((o) => fatLines(outline, ACCENT, strong ? 2.5 : 1.5, o));
    }
    return group;
  }

  // A material that is clear beyond a distance from a point of the body's frame.
  function fading(options, near) {
    const material = new THREE.MeshBasicMaterial(options);
    if (!near) return material;
    material.onBeforeCompile = (shader) => {
      shader.uniforms.nearPoint = { value: new THREE.Vector3(...near.point) };
      shader.uniforms.nearRadius = { value: near.radius };
      shader.vertexShader = "varying vec3 vPlace;\n" + shader.vertexShader.replace("#include <begin_vertex>",
        "#include <begin_vertex>\n  vPlace = position;");
      shader.fragmentShader = "varying vec3 vPlace;\nuniform vec3 nearPoint;\nuniform float nearRadius;\n" +
        shader.fragmentShader.replace("#include <color_fragment>", "#include <color_fragment>\n" +
          "  diffuseColor.a *= 1.0 - smoothstep(0.6 * nearRadius, nearRadius, distance(vPlace, nearPoint));");
    };
    return material;
  }

  // The parts of segments (flat list of ends) inside a ball.
  function within(ends, { point, radius }) {
    const kept = [];
    for (let k = 0; k < ends.length; k += 6) {
      const p = ends.slice(k, k + 3);
      const d = [0, 1, 2].map((i) => ends[k + 3 + i] - p[i]);
      const r = p.map((x, i) => x - point[i]);
      const [a, b, c] = [dot3(d, d), dot3(r, d), dot3(r, r) - radius * radius];
      const root = Math.sqrt(b * b - a * c); // NaN where the line misses the ball
      const [lo, hi] = a > 0 ? [Math.max((-b - root) / a, 0), Math.min((-b + root) / a, 1)] : [0, -1];
      if (lo < hi) for (const s of [lo, hi]) kept.push(...p.map((x, i) => x + s * d[i]));
    }
    return kept;
  }

  const dot3 = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];

  const pixelSized = []; // objects whose scale is kept so that one unit is `userData.pixels` on the screen

  function dot(position, pixels, colour, order) {
    const material = new THREE.MeshBasicMaterial({ color: colour, depthTest: false, depthWrite: false, transparent: true });
    const ball = named(new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), material), "dot", order);
    ball.position.set(...position);
    ball.userData.pixels = pixels;
    pixelSized.push(ball);
    return ball;
  }

  // The contact point with its normal, over everything else.
  function markerObject(point, normal) {
    const marker = named(new THREE.Group(), "contact");
    marker.position.set(...point);
    marker.userData.pixels = 1;
    pixelSized.push(marker);
    const solid = (colour) => new THREE.MeshBasicMaterial({ color: colour, depthTest: false, depthWrite: false, transparent: true });
    const piece = (geometry, colour, order, name) => named(new THREE.Mesh(geometry, solid(colour)), name, order);
    if (normal) {
      const arrow = named(new THREE.Group(), "normal");
      const shape = (grow, colour, order) => {
        const shaft = piece(new THREE.CylinderGeometry(1.6 + grow, 1.6 + grow, 58, 16), colour, order, "shaft");
        shaft.position.y = 29;
        const head = piece(new THREE.ConeGeometry(6.5 + 1.6 * grow, 18 + 2 * grow, 24), colour, order, "head");
        head.position.y = 66;
        arrow.add(shaft, head);
      };
      shape(1.3, "#ffffff", 20);
      shape(0, ACCENT, 21);
      arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...normal).normalize());
      marker.add(arrow);
    }
    marker.add(piece(new THREE.SphereGeometry(8, 24, 16), "#ffffff", 22, "halo"));
    marker.add(piece(new THREE.SphereGeometry(5.8, 24, 16), ACCENT, 23, "dot"));
    return marker;
  }

  // The curve that the bodies share, over everything else: a thick line on a white one.
  function sharedObject(points) {
    const group = named(new THREE.Group(), "contact set");
    const line = (colour, width, order) => {
      const geometry = new THREE.LineGeometry();
      geometry.setPositions(points);
      const material = { color: colour, linewidth: width, transparent: true, depthTest: false, depthWrite: false };
      return named(new THREE.Line2(geometry, new THREE.LineMaterial(material)), "contact line", order);
    };
    group.add(line("#ffffff", 8, 18), line(ACCENT, 5, 19));
    return group;
  }

  // What two surfaces at rest share: one kind of it; they are translucent, so that nothing hides it.
  const LINE_WIDTHS = { line: 3.5, "thick line": 7 };

  function layerObject(layer) {
    const group = named(new THREE.Group(), `layer ${layer.name}`);
    const over = { transparent: true, depthWrite: false };
    if (layer.kind === "fill") {
      const surface = new THREE.BufferGeometry();
      surface.setAttribute("position", new THREE.BufferAttribute(new Float32Array(layer.points), 3));
      group.add(named(new THREE.Mesh(surface, new THREE.MeshBasicMaterial({
        color: layer.colour, side: THREE.DoubleSide, opacity: 0.75, polygonOffset: true,
        polygonOffsetFactor: -1, polygonOffsetUnits: -2, ...over,
      })), "fill", 4));
    } else if (layer.kind in LINE_WIDTHS) {
      if (!layer.points.length) return group;
      const width = LINE_WIDTHS[layer.kind];
      group.add(named(fatLines(layer.points, "#ffffff", width + 2.5, { opacity: 0.85, ...over }), "halo", 6));
      group.add(named(fatLines(layer.points, layer.colour, width, over), "line", 7));
    } else {
      for (let k = 0; k < layer.points.length; k += 3) group.add(pointObject(layer.points.slice(k, k + 3), layer));
    }
    return group;
  }

  // A node is a ring, a cusp a diamond, an isolated point a target, what is undecided a ball.
  function pointObject(position, { kind, colour }) {
    const discs = { node: [["#ffffff", 9], [colour, 7.5], ["#ffffff", 4]], cusp: [["#ffffff", 11], [colour, 8.5]],
                    isolated: [["#ffffff", 10.5], [colour, 9], ["#ffffff", 6.5], [colour, 4]],
                    open: [["#ffffff", 9.5], [colour, 8]] }[kind];
    const group = named(new THREE.Group(), kind);
    discs.forEach(([paint, pixels], k) => {
      const ball = dot(position, pixels, paint, 24 + k);
      if (kind === "cusp") ball.geometry = new THREE.SphereGeometry(1, 4, 2);
      group.add(ball);
    });
    return group;
  }

  function pathObject(body, which, name, lo, hi) {
    const times = new Set(body.motion.times.length < 400 ? body.motion.times : []);
    for (let k = 0; k <= PATH_STEPS; k++) times.add(lo + ((hi - lo) * k) / PATH_STEPS);
    body.pathTimes = [...times].sort((x, y) => x - y);
    const points = body.pathTimes.flatMap((t) => apply(body.motion.at(t), body.carried));
    const line = (opacity, width) => {
      const geometry = new THREE.LineGeometry();
      geometry.setPositions(points);
      return new THREE.Line2(geometry, new THREE.LineMaterial({
        color: matchMedia("(prefers-color-scheme: dark)").matches ? COLOURS[which] : DARK[which], linewidth: width,
        transparent: true, opacity, depthWrite: false,
      }));
    };
    const group = named(new THREE.Group(), `path of ${name}`);
    const ahead = named(line(0.28, 1.5), "path ahead", 2);
    body.travelled = named(line(0.9, 2.25), "path travelled", 3);
    group.add(ahead, body.travelled);
    return group;
  }

  // An object whose matrix is set by hand.
  function placed(object) {
    object.matrixAutoUpdate = false;
    return object;
  }

  function place(object, T, size) {
    const [a, b, c, x, d, e, f, y, g, h, i, z] = T;
    const s = size;
    object.matrix.set(a * s, b * s, c * s, x, d * s, e * s, f * s, y, g * s, h * s, i * s, z, 0, 0, 0, 1);
    object.matrixWorldNeedsUpdate = true;
  }

  // -- the stage --------------------------------------------------------------------------------------------

  // byHand: values of joints by their numbers, while these are not those of the time t
  const state = { pair: 0, t: 0, byHand: null, playing: false, dwell: 0, passedContact: false, moved: false };
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(24, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const content = named(new THREE.Group(), "content");
  scene.add(content, camera);
  let renderer = null;
  let controls = null;
  let pair = null; // the chosen entry of DATA.pairs
  let marker = null;
  let shared = null; // the drawn contact set, where it is more than a point
  let lastFrame = null;
  let wanted = false; // a frame is asked for

  function setUpStage() {
    try {
      renderer = new THREE.WebGLRenderer({ canvas: $("stage"), antialias: true, alpha: true });
    } catch (error) {
      $("trouble").textContent = "This browser offers no WebGL, so the bodies cannot be drawn. The facts beside are complete.";
      $("trouble").hidden = false;
      return;
    }
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    scene.add(new THREE.HemisphereLight("#ffffff", "#d8d2c6", 2.0));
    const key = new THREE.DirectionalLight("#fffaf0", 1.7);
    key.position.set(-0.6, 0.9, 0.7); // in the camera's frame: from the upper left
    camera.add(key, key.target);
    key.target.position.set(0, 0, -1);
    controls = new THREE.OrbitControls(camera, $("stage"));
    controls.zoomToCursor = true;
    controls.addEventListener("change", requestFrame);
    controls.addEventListener("end", () => { state.moved = true; writeHash(); });
    addEventListener("resize", () => {
      resize();
      if (!state.moved) resetView();
      requestFrame();
    });
  }

  // The free part of the window: right of the card and above the bar.
  function freeArea() {
    const card = $("card").getBoundingClientRect();
    const bar = $("bar").getBoundingClientRect();
    const narrow = innerWidth <= 760;
    const left = narrow ? 0 : card.right;
    const top = narrow ? card.bottom : 0;
    const bottom = isCurve() ? innerHeight : bar.top;
    return { left, top, width: innerWidth - left, height: Math.max(bottom - top, 50) };
  }

  function resize() {
    if (!renderer) return;
    renderer.setSize(innerWidth, innerHeight, false);
    camera.aspect = innerWidth / innerHeight;
    const area = freeArea();
    const x = area.left + area.width / 2 - innerWidth / 2;
    const y = area.top + area.height / 2 - innerHeight / 2;
    camera.setViewOffset(innerWidth, innerHeight, -x, -y, innerWidth, innerHeight); // also updates the projection
  }

  function choosePair(index) {
    state.pair = index;
    pair = DATA.pairs[index];
    content.clear();
    pixelSized.length = 0;
    const [lo, hi] = pair.window;
    pair.bodies.forEach((body, which) => {
      const name = pair.names[which];
      body.motion ??= motionOf(body, pair);
      body.object = bodyObject(body, which, name);
      body.elements.forEach((element, k) => body.object.add(elementObject(element, k === 0, nearOf(body))));
      content.add(body.object);
      body.ghost = null;
      body.deforms = Boolean(geometryOf(body.mesh).frames);
      if (body.moving && !body.deforms && hi > lo) {
        body.ghost = ghostObject(body, which, name);
        place(body.ghost, body.motion.at(lo), body.size);
        content.add(body.ghost, pathObject(body, which, name, lo, hi));
      }
    });
    marker = pair.point ? markerObject(pair.point, pair.normal) : null;
    if (marker) content.add(marker);
    shared = pair.shared.length > 3 ? sharedObject(pair.shared) : null;
    if (shared) content.add(shared);
    for (const layer of pair.layers) content.add(layer.object = layerObject(layer));
    if (whole) putAssembly();
    $("bar").hidden = isCurve();
    state.playing = false;
    listJoints();
    showFacts();
    resize();
    setTime(pair.contact ?? lo);
    resetView();
  }

  // How far from the contact faces are coloured, in the body's frame; null where nothing is known of it.
  const NEAR = 0.35;
  function nearOf(body) {
    if (!pair.point || body.deforms) return null;
    const radius = NEAR * Math.min(...pair.bodies.map((b) => b.size));
    return { point: body.carried.map((x) => x / body.size), radius: Math.max(radius / body.size, 1e-3) };
  }

  // -- the assembly -----------------------------------------------------------------------------------------

  const whole = DATA.assembly ?? null;
  const OTHER = "#8d949b";
  const behind = named(new THREE.Group(), "other parts"); // in the frame of the assembly
  const hiddenParts = new Set();

  function setUpAssembly() {
    if (!whole) return;
    behind.matrixAutoUpdate = false;
    whole.bodies.forEach((body) => {
      const { surface, outline } = geometryOf(body.mesh);
      body.motion = motionOf(body, whole);
      body.object = placed(named(new THREE.Group(), `part ${body.name}`));
      if (surface.index.count) body.object.add(new THREE.Mesh(surface, OTHERS.surface));
      if (outline.index.count) body.object.add(new THREE.LineSegments(outline, OTHERS.lines));
      behind.add(body.object);
    });
    $("parts").hidden = $("all").hidden = false;
    $("whole").textContent = "this pair";
    $("others").addEventListener("change", showOthers);
    $("filter").addEventListener("input", listParts);
    listParts();
  }

  const OTHERS = {
    surface: new THREE.MeshLambertMaterial({ color: OTHER, flatShading: true, side: THREE.DoubleSide, transparent: true,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 }),
    lines: new THREE.LineBasicMaterial({ color: OTHER, transparent: true }),
  };

  // Faint parts hide nothing, so that the contact is in sight whatever stands before it.
  function showOthers() {
    const how = $("others").value;
    behind.visible = how !== "hidden";
    Object.assign(OTHERS.surface, { opacity: how === "solid" ? 1 : 0.1, depthWrite: how === "solid", transparent: how !== "solid" });
    Object.assign(OTHERS.lines, { opacity: how === "solid" ? 0.7 : 0.22, depthWrite: how === "solid" });
    OTHERS.surface.needsUpdate = true;
    requestFrame();
  }

  // One line for each part, with a box that shows or hides it; those of the chosen pair come first.
  const MOST_LISTED = 400;
  function listParts() {
    const words = $("filter").value.trim().toLowerCase();
    const chosen = whole.members[state.pair] ?? [];
    const order = whole.bodies.map((body, k) => ({ body, k })).filter(({ body }) => body.name.toLowerCase().includes(words));
    order.sort((x, y) => chosen.includes(y.k) - chosen.includes(x.k));
    $("partsCount").textContent = `${whole.bodies.length} parts` + (hiddenParts.size ? `, ${hiddenParts.size} hidden` : "");
    $("partsList").replaceChildren(...order.slice(0, MOST_LISTED).map(({ body, k }) => {
      const box = element("input", "");
      Object.assign(box, { type: "checkbox", checked: !hiddenParts.has(k), name: body.name });
      box.addEventListener("change", () => showPart(k, box.checked));
      const sign = element("i", "");
      sign.style.setProperty("--colour", chosen.includes(k) ? COLOURS[chosen.indexOf(k)] : OTHER);
      const label = element("label", "");
      label.append(box, sign, element("span", body.name));
      const item = element("li", "");
      item.append(label);
      return item;
    }));
  }

  function showPart(k, visible) {
    if (visible) hiddenParts.delete(k);
    else hiddenParts.add(k);
    showMembers();
    $("partsCount").textContent = `${whole.bodies.length} parts` + (hiddenParts.size ? `, ${hiddenParts.size} hidden` : "");
    requestFrame();
  }

  // The two bodies of the pair are drawn by themselves, and all others behind them.
  function showMembers() {
    const members = whole.members[state.pair];
    whole.bodies.forEach((body, k) => { body.object.visible = !hiddenParts.has(k) && !members.includes(k); });
    members.forEach((k, which) => {
      const body = pair.bodies[which];
      body.object.visible = !hiddenParts.has(k);
      if (body.ghost) body.ghost.userData.hidden = hiddenParts.has(k);
    });
  }

  const wholeRadius = () => (2 * whole.unit) / pair.unit;

  // Carries the frame of the assembly into that of the pair.
  function putAssembly() {
    const s = whole.unit / pair.unit;
    const [x, y, z] = [0, 1, 2].map((i) => (whole.origin[i] - pair.origin[i]) / pair.unit);
    behind.matrix.set(s, 0, 0, x, 0, s, 0, y, 0, 0, s, z, 0, 0, 0, 1);
    behind.matrixWorldNeedsUpdate = true;
    content.add(behind);
    showMembers();
    showOthers();
    listParts();
  }

  // -- camera -----------------------------------------------------------------------------------------------

  // Points of both bodies where they touch (or end) and where they start, unless the start is far away.
  function framedPoints() {
    const [lo, hi] = pair.window;
    const here = pointsAt(pair.contact ?? hi);
    const both = here.concat(pointsAt(lo));
    const size = (points) => new THREE.Box3().setFromPoints(points).getSize(new THREE.Vector3()).length();
    return pair.contact === null || size(both) <= 3 * size(here) ? both : here;
  }

  function pointsAt(t) {
    const all = pair.bodies.flatMap((body) => {
      if (body.deforms) deform(geometryOf(body.mesh), t);
      const positions = geometryOf(body.mesh).surface.getAttribute("position");
      const step = Math.ceil(positions.count / 3000);
      const m = new THREE.Group();
      place(m, body.motion.at(t), body.size);
      const points = [];
      for (let k = 0; k < positions.count; k += step) {
        points.push(new THREE.Vector3().fromBufferAttribute(positions, k).applyMatrix4(m.matrix));
      }
      return points;
    });
    for (const body of pair.bodies) if (body.deforms) deform(geometryOf(body.mesh), state.t);
    return all;
  }

  function framedRadius() {
    pair.radius ??= Math.max(new THREE.Box3().setFromPoints(framedPoints()).getSize(new THREE.Vector3()).length() / 2, 1e-6);
    return pair.radius;
  }

  // Distance at which a length of `half` (seen square on) takes half the height of the free part.
  function distanceFor(half) {
    return (half * innerHeight) / (freeArea().height * Math.tan((camera.fov * Math.PI) / 360));
  }

  // A direction from which the contact point is in sight, with the normal across the picture, near the usual one.
  function viewDirection() {
    const usual = new THREE.Vector3(0.5, -0.75, 0.45).normalize();
    if (!marker) return usual;
    const normal = pair.normal ? new THREE.Vector3(...pair.normal) : new THREE.Vector3();
    const choices = [];
    for (const elevation of [0.04, 0.15, 0.32, 0.55, -0.15]) {
      for (let k = 0; k < 16; k++) {
        const azimuth = ((k + 0.5) * Math.PI) / 8; // never along a face of an upright box
        const d = new THREE.Vector3(Math.cos(azimuth), Math.sin(azimuth), Math.tan(elevation)).normalize();
        choices.push({ d, score: 1.5 * d.dot(usual) - Math.max(Math.abs(d.dot(normal)) - 0.4, 0) });
      }
    }
    choices.sort((p, q) => q.score - p.score);
    return (choices.find(({ d }) => inSight(d)) ?? choices[0]).d;
  }

  function inSight(direction) {
    const radius = framedRadius();
    const from = new THREE.Vector3(...pair.point).addScaledVector(direction, 0.004 * radius);
    const ray = new THREE.Raycaster(from, direction);
    content.updateMatrixWorld(true);
    return pair.bodies.every((body) => {
      const surface = body.object.children[0];
      return !surface.isMesh || ray.intersectObject(surface, false).length === 0;
    });
  }

  function look(target, distance, direction) {
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(direction, distance);
    controls.update();
    requestFrame();
  }

  // Everything in the picture, as large as the free part of the window allows.
  function resetView() {
    if (!controls) return;
    const direction = (pair.direction ??= viewDirection());
    const right = new THREE.Vector3().crossVectors(camera.up, direction).normalize();
    const upward = new THREE.Vector3().crossVectors(direction, right);
    const points = framedPoints();
    const target = new THREE.Vector3();
    const [across, along, deep] = [right, upward, direction].map((axis) => {
      const values = points.map((p) => p.dot(axis));
      const [least, most] = [values.reduce((x, y) => Math.min(x, y)), values.reduce((x, y) => Math.max(x, y))];
      target.addScaledVector(axis, (least + most) / 2);
      return (most - least) / 2;
    });
    const area = freeArea();
    const half = Math.max((across * area.height) / area.width, along, 1e-3 * framedRadius());
    look(target, deep + distanceFor(1.18 * half), direction);
    state.moved = false;
    writeHash();
  }

  // All parts that are shown, from where the camera looks.
  function lookAtAll() {
    if (!controls || !whole) return;
    scene.updateMatrixWorld(true);
    const box = new THREE.Box3();
    const shown = [...whole.bodies, ...pair.bodies].filter((body) => body.object.visible);
    for (const body of shown) box.union(new THREE.Box3().setFromObject(body.object));
    if (box.isEmpty()) return;
    const radius = box.getSize(new THREE.Vector3()).length() / 2;
    const direction = camera.position.clone().sub(controls.target).normalize();
    look(box.getCenter(new THREE.Vector3()), radius + distanceFor(0.75 * radius), direction);
    state.moved = true;
    writeHash();
  }

  // Near enough that the smaller body fills the picture.
  function lookAtContact() {
    if (!controls || !marker) return;
    const direction = camera.position.clone().sub(controls.target).normalize();
    const radius = Math.min(...pair.bodies.map((body) => body.size));
    look(new THREE.Vector3(...pair.point), distanceFor(radius * 0.3), direction);
    state.moved = true;
    writeHash();
  }

  // -- time -------------------------------------------------------------------------------------------------

  const clamp = (t) => Math.min(Math.max(t, pair.window[0]), pair.window[1]);

  function setTime(t) {
    state.t = clamp(t);
    state.byHand = null;
    pose();
  }

  // Where a body is: at the time, or where its joints have been put by hand.
  const poseOf = ({ motion }) => (state.byHand && motion.with ? motion.with((k) => state.byHand[k]) : motion.at(state.t));

  function pose() {
    for (const body of pair.bodies) {
      place(body.object, poseOf(body), body.size);
      if (body.deforms) deform(geometryOf(body.mesh), state.t);
      for (const part of body.object.children) {
        if (part.name.startsWith("element ")) part.visible = body.deforms ? atContact() : !state.byHand;
      }
      if (body.ghost) {
        body.ghost.visible = state.t > pair.window[0] && !body.ghost.userData.hidden;
        body.travelled.geometry.instanceCount = body.pathTimes.filter((s) => s <= state.t).length - 1;
        body.travelled.visible = body.travelled.geometry.instanceCount > 0;
      }
    }
    if (whole) for (const body of whole.bodies) place(body.object, poseOf(body), body.size);
    for (const mark of [marker, shared]) {
      if (!mark) continue;
      mark.visible = !state.byHand;
      fade(mark, atContact() ? 1 : 0.4);
    }
    showTime();
    showJoints();
    requestFrame();
  }

  const isCurve = () => ["CURVE", "APART"].includes(pair.status); // of bodies at rest: there is no time
  const atContact = () => pair.contact !== null && state.t === clamp(pair.contact) && !state.byHand;

  function fade(object, opacity) {
    object.traverse((part) => { if (part.material) part.material.opacity = opacity; });
  }

  function play(on) {
    if (on && state.t >= pair.window[1]) setTime(pair.window[0]);
    state.playing = on && pair.window[1] > pair.window[0];
    state.dwell = 0;
    lastFrame = null;
    showTime();
    writeHash();
    requestFrame();
  }

  // Moves the time on by `seconds` of the player, resting exactly at the contact on the way.
  function advance(seconds) {
    if (state.dwell > 0) {
      state.dwell -= seconds;
      return;
    }
    const [lo, hi] = pair.window;
    const next = state.t + (seconds * (hi - lo)) / SECONDS;
    if (pair.contact !== null && state.t < pair.contact && next >= pair.contact) {
      setTime(pair.contact);
      state.dwell = DWELL;
    } else {
      setTime(next);
    }
    if (state.t >= hi && state.dwell <= 0) play(false);
    writeHash(true);
  }

  // -- frames -----------------------------------------------------------------------------------------------

  function requestFrame() {
    if (wanted) return;
    wanted = true;
    requestAnimationFrame(frame);
  }

  function frame(now) {
    wanted = false;
    if (state.playing) {
      advance(lastFrame === null ? 0 : Math.min((now - lastFrame) / 1000, 0.25));
      lastFrame = now;
      requestFrame();
    }
    if (renderer) draw();
  }

  function draw() {
    const distance = camera.position.distanceTo(controls.target);
    const radius = whole ? Math.max(framedRadius(), wholeRadius()) : framedRadius();
    camera.near = Math.max(distance / 500, (distance - 20 * radius) / 2);
    camera.far = distance + 40 * radius;
    camera.updateProjectionMatrix();
    scene.updateMatrixWorld(true);
    const perPixel = (2 * Math.tan((camera.fov * Math.PI) / 360)) / innerHeight;
    const place3 = new THREE.Vector3();
    for (const object of pixelSized) {
      const depth = -object.getWorldPosition(place3).applyMatrix4(camera.matrixWorldInverse).z;
      const parent = object.parent.getWorldScale(new THREE.Vector3()).x;
      object.scale.setScalar((object.userData.pixels * perPixel * Math.max(depth, camera.near)) / parent);
    }
    renderer.render(scene, camera);
    drawTriad(perPixel * distance);
  }

  // Axes as the camera sees them, and a length in the unit of the scene; perPixel: of the page's frame, at the target.
  const AXES = [["x", "#d2493c", [1, 0, 0]], ["y", "#3f9650", [0, 1, 0]], ["z", "#3c6fd2", [0, 0, 1]]];
  function drawTriad(perPixel) {
    const back = camera.quaternion.clone().invert();
    const arms = AXES.map(([name, colour, axis]) => ({ name, colour, v: new THREE.Vector3(...axis).applyQuaternion(back) }));
    arms.sort((p, q) => p.v.z - q.v.z); // the nearest one last, over the others
    const [svg, caption] = [$("triad").firstElementChild, $("triad").lastElementChild];
    svg.innerHTML = arms.map(({ name, colour, v }) => {
      const [x, y] = [v.x * 22, -v.y * 22];
      return `<line x2="${x}" y2="${y}" stroke="${colour}"/><text x="${x * 1.36}" y="${y * 1.36}" fill="${colour}">${name}</text>`;
    }).join("");
    const raw = 90 * perPixel * pair.unit;
    const power = 10 ** Math.floor(Math.log10(raw));
    const length = [5, 2, 1].map((k) => k * power).find((x) => x <= raw);
    caption.firstElementChild.style.width = `${length / (perPixel * pair.unit)}px`;
    caption.lastElementChild.textContent = `${Number(length.toPrecision(1))}${DATA.unit ? ` ${DATA.unit}` : ""}`;
  }

  // -- words and controls -----------------------------------------------------------------------------------

  function element(tag, text, className = "") {
    const node = document.createElement(tag);
    node.textContent = text;
    if (className) node.className = className;
    return node;
  }

  // The joints of all bodies in the picture, by their numbers, and what shows each of them.
  let shownJoints = [];

  function listJoints() {
    const bodies = whole ? [...pair.bodies, ...whole.bodies] : pair.bodies;
    const numbers = [...new Set(bodies.flatMap((body) => body.joints ?? []))].sort((x, y) => x - y);
    shownJoints = numbers.map((k) => {
      const { name, unit, least, most, limited, follows } = JOINTS[k];
      const digits = Math.min(Math.max(4 - Math.floor(Math.log10(most - least)), 0), 12);
      const words = unit || DATA.unit || "";
      const [item, slider, value] = [element("li", ""), element("input", ""), element("output", "")];
      Object.assign(slider, { type: "range", id: `joint${k}`, name, min: least, max: most, step: "any" });
      slider.addEventListener("input", () => setJoint(k, slider.valueAsNumber));
      value.htmlFor = slider.id;
      const title = element("label", name);
      title.htmlFor = slider.id;
      const leader = follows && numbers.includes(follows[0]) ? JOINTS[follows[0]].name : null;
      const ends = [least, most].map((x) => element("span", String(Number(x.toPrecision(6)))));
      item.title = (limited ? "limits " : "no limits; shown ") + `${least} to ${most} ${words}`.trim() + (leader ? `; follows ${leader}` : "");
      item.append(title, value, ends[0], slider, ends[1]);
      return { k, slider, item, show: (x) => { value.textContent = `${(x + 0).toFixed(digits)} ${words}`.trim(); } };
    });
    $("joints").hidden = !shownJoints.length;
    $("jointsCount").textContent = shownJoints.length === 1 ? "1 joint" : `${shownJoints.length} joints`;
    $("jointList").replaceChildren(...shownJoints.map(({ item }) => item));
  }

  const jointValue = (k) => (state.byHand ? state.byHand[k] : valueAt(JOINTS[k], state.t));

  function showJoints() {
    for (const { k, slider, show } of shownJoints) {
      const value = jointValue(k);
      if (slider.valueAsNumber !== value) slider.value = String(value);
      show(value);
    }
    $("offPath").hidden = !state.byHand;
    $("bar").classList.toggle("off", Boolean(state.byHand));
  }

  // A joint put by hand: one that follows another moves that one, and all that follow it.
  function setJoint(k, value) {
    setJoints(Object.fromEntries(shownJoints.map((joint) => [joint.k, joint.k === k ? value : jointValue(joint.k)])), k);
  }

  function setJoints(values, moved) {
    state.playing = false;
    const follows = moved === undefined ? null : JOINTS[moved].follows;
    if (follows && follows[0] in values && follows[1] !== 0) values[follows[0]] = (values[moved] - follows[2]) / follows[1];
    for (const { k } of shownJoints) {
      const [leader, ratio, offset] = JOINTS[k].follows ?? [];
      if (leader in values) values[k] = ratio * values[leader] + offset;
    }
    state.byHand = values;
    pose();
    writeHash();
  }

  function showFacts() {
    const many = DATA.pairs.length > 1;
    $("title").textContent = pair.title;
    $("title").hidden = many;
    $("pairs").hidden = !many;
    $("pairs").value = String(state.pair);
    showSteps();
    $("status").textContent = STATUS[pair.status];
    $("status").className = pair.status;
    $("rows").replaceChildren(...pair.rows.flatMap(([label, text]) => [element("dt", label), element("dd", text)]));
    $("text").textContent = pair.text;
    $("elements").replaceChildren(...pair.names.map((name, which) => {
      const item = element("li", "");
      const body = pair.bodies[which];
      item.style.setProperty("--colour", COLOURS[which]);
      const [first] = body.elements;
      const touched = first ? first.label || `${first.kind} ${first.index}` : "";
      item.append(element("span", name), element("span", touched || (body.deforms ? "deforms" : body.moving ? "moves" : "rests")));
      return item;
    }));
    showLayers();
    $("contact").disabled = pair.contact === null;
    $("closer").hidden = !pair.point;
    showTimeline();
  }

  // Contacts in the order of their times: which of them is shown, and all of them on the bar.
  const contacts = DATA.pairs.map((p, k) => ({ k, time: p.contact })).filter(({ time }) => time !== null);
  contacts.sort((x, y) => x.time - y.time || x.k - y.k);

  function showSteps() {
    const many = Boolean(whole) && contacts.length > 0;
    $("stepper").hidden = $("ticks").hidden = !many;
    if (!many) return;
    const at = contacts.findIndex(({ k }) => k === state.pair);
    $("count").textContent = at < 0 ? `${contacts.length} contacts` : `${at + 1} of ${contacts.length}`;
    $("before").disabled = at === 0;
    $("after").disabled = at === contacts.length - 1;
    const [lo, hi] = pair.window;
    $("ticks").replaceChildren(...contacts.filter(({ time }) => lo <= time && time <= hi).map(({ k, time }) => {
      const tick = element("button", "", k === state.pair ? "chosen" : "");
      tick.type = "button";
      tick.title = `${DATA.pairs[k].title}: ${time}`;
      tick.tabIndex = -1; // the buttons beside the count step through them
      tick.style.left = `${hi > lo ? (100 * (time - lo)) / (hi - lo) : 0}%`;
      tick.addEventListener("click", () => stepTo(k));
      return tick;
    }));
  }

  function stepTo(k) {
    choosePair(k);
    writeHash();
  }

  function step(by) {
    const at = contacts.findIndex(({ k }) => k === state.pair);
    const next = contacts[at < 0 ? 0 : at + by];
    if (whole && next) stepTo(next.k);
  }

  // One line for each part of the picture of a curve, with a box that shows or hides it.
  function showLayers() {
    $("layers").hidden = !isCurve();
    if (!isCurve()) return;
    const parts = pair.bodies.flatMap((body, which) => {
      const [surface, ...lines] = body.object.children;
      const part = (object, name, kind, colour) => ({ name: `${pair.names[which]}${name}`, kind, colour, object });
      return [part(surface, "", "fill", COLOURS[which]), ...lines.slice(0, 1).map((o) => part(o, ": rulings", "rulings", DARK[which]))];
    });
    $("layers").replaceChildren(...[...parts, ...pair.layers].map((part) => {
      const box = element("input", "");
      Object.assign(box, { type: "checkbox", checked: true, name: part.name });
      box.addEventListener("change", () => { part.object.visible = box.checked; requestFrame(); });
      const sign = element("i", "", part.kind.replace(" ", "-"));
      sign.style.setProperty("--colour", part.colour);
      const label = element("label", "");
      label.append(box, sign, element("span", part.name));
      const item = element("li", "");
      item.append(label);
      return item;
    }));
  }

  function showTimeline() {
    const [lo, hi] = pair.window;
    const percent = (t) => (hi > lo ? (100 * (clamp(t) - lo)) / (hi - lo) : 0);
    const kindClass = (kind) => kind.replace(" ", "-");
    const bars = pair.timeline.map(([start, end, kind]) => {
      const bar = element("i", "", kindClass(kind));
      bar.style.left = `${percent(start)}%`;
      bar.style.width = `${hi > lo ? percent(end) - percent(start) : 100}%`;
      bar.title = `${kind}: ${start} to ${end}`;
      return bar;
    });
    bars.at(-1)?.classList.add("last");
    if (pair.contact !== null) {
      const tick = element("b", "");
      tick.style.left = `${percent(pair.contact)}%`;
      bars.push(tick);
    }
    $("timeline").replaceChildren(...bars);
    $("scaleStart").textContent = pair.span[0];
    $("scaleEnd").textContent = pair.span[1];
    const words = { contact: "in contact", "not asked": "after the first contact" };
    if (pair.status === "INITIAL_CONTACT") words["not asked"] = "not asked";
    $("legend").replaceChildren(...[...new Set(pair.timeline.map((s) => s[2]))].map((kind) => {
      const entry = element("span", "");
      entry.append(element("i", "", kindClass(kind)), words[kind] ?? kind);
      return entry;
    }));
    Object.assign($("slider"), { min: lo, max: hi, disabled: !(hi > lo) });
    $("play").disabled = !(hi > lo);
  }

  function showTime() {
    const [lo, hi] = pair.window;
    const digits = Math.min(Math.max(4 - Math.floor(Math.log10(hi - lo || 1)), 0), 12);
    $("time").textContent = state.t.toFixed(Math.abs(state.t) < 1e7 ? digits : 0);
    $("time").className = atContact() ? "now" : "";
    if ($("slider").valueAsNumber !== state.t) $("slider").value = String(state.t);
    $("playShape").setAttribute("d", state.playing ? "M5 3h4v14H5zM11 3h4v14h-4z" : "M6 3l11 7-11 7z");
    $("play").setAttribute("aria-label", state.playing ? "pause" : "play");
  }

  function setUpControls() {
    $("pairs").replaceChildren(...DATA.pairs.map((p, k) => {
      const option = element("option", `${p.title}: ${STATUS[p.status]}`);
      option.value = String(k);
      return option;
    }));
    $("pairs").addEventListener("change", () => choosePair(Number($("pairs").value)));
    $("slider").addEventListener("input", () => { stopAt($("slider").valueAsNumber); });
    $("play").addEventListener("click", () => play(!state.playing));
    $("contact").addEventListener("click", toContact);
    $("whole").addEventListener("click", resetView);
    $("closer").addEventListener("click", lookAtContact);
    $("back").addEventListener("click", () => stopAt(state.t));
    $("all").addEventListener("click", lookAtAll);
    $("before").addEventListener("click", () => step(-1));
    $("after").addEventListener("click", () => step(1));
    addEventListener("keydown", (event) => {
      if (event.target.closest("select, button") && event.key === " ") return;
      if (event.target.closest("input[type=search]")) return;
      const act = {
        " ": () => play(!state.playing), c: toContact, r: resetView, z: lookAtContact, a: lookAtAll, n: () => step(1), p: () => step(-1),
      }[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act();
    });
    addEventListener("hashchange", readHash);
  }

  function stopAt(t) {
    state.playing = false;
    setTime(t);
    writeHash();
  }

  function toContact() {
    if (pair.contact !== null) stopAt(pair.contact);
  }

  // -- the URL hash: #t=0.4&pair=1&joints=30,45&camera=eye x,y,z,target x,y,z ------------------------------------------

  let hashTimer = null;

  // Browsers refuse more than about a hundred changes of the address in half a minute: while playing, a few
  // per second must do.
  function writeHash(lazily = false) {
    if (lazily && hashTimer !== null) return;
    clearTimeout(hashTimer);
    hashTimer = setTimeout(() => {
      hashTimer = null;
      const parts = [`t=${state.t}`];
      if (DATA.pairs.length > 1) parts.push(`pair=${state.pair}`);
      if (state.byHand) parts.push(`joints=${shownJoints.map(({ k }) => state.byHand[k]).join(",")}`);
      if (state.moved && controls) {
        const numbers = [...camera.position.toArray(), ...controls.target.toArray()];
        parts.push(`camera=${numbers.map((x) => Number(x.toPrecision(6))).join(",")}`);
      }
      history.replaceState(null, "", `#${parts.join("&")}`);
    }, lazily ? 400 : 60);
  }

  function readHash() {
    clearTimeout(hashTimer); // what the reader typed wins over what was about to be written
    hashTimer = null;
    const given = new URLSearchParams(location.hash.slice(1));
    const index = Number(given.get("pair") ?? state.pair);
    if (index !== state.pair && DATA.pairs[index]) choosePair(index);
    const t = Number.parseFloat(given.get("t"));
    if (Number.isFinite(t)) stopAt(t);
    const values = (given.get("joints") ?? "").split(",").map(Number);
    if (given.get("joints") && values.length === shownJoints.length && values.every(Number.isFinite)) {
      setJoints(Object.fromEntries(shownJoints.map(({ k }, i) => [k, values[i]])));
    }
    const numbers = (given.get("camera") ?? "").split(",").map(Number);
    if (controls && numbers.length === 6 && numbers.every(Number.isFinite)) {
      camera.position.set(...numbers.slice(0, 3));
      controls.target.set(...numbers.slice(3));
      controls.update();
      state.moved = true;
      requestFrame();
    }
  }

  // -- for scripts ------------------------------------------------------------------------------------------

  // Pixel (x, y) of the window where a point of the page's frame is drawn.
  function project(point) {
    camera.updateMatrixWorld(true);
    const p = new THREE.Vector3(...point).project(camera);
    return [((p.x + 1) / 2) * innerWidth, ((1 - p.y) / 2) * innerHeight];
  }

  function objects() {
    const list = [];
    content.traverse((o) => {
      if (o.name) list.push({ name: o.name, type: o.type, visible: o.visible, smooth: o.material?.flatShading === false });
    });
    return list;
  }

  window.firstcontact = {
    get time() { return state.t; },
    get window() { return pair.window; },
    get contactTime() { return pair.contact; },
    get isPlaying() { return state.playing; },
    get atContact() { return atContact(); },
    get contactVisible() { return marker !== null && marker.visible; },
    get contactPixel() { return marker && project(pair.point); },
    get contactCurve() {
      return Array.from({ length: pair.shared.length / 3 }, (_, k) => project(pair.shared.slice(3 * k, 3 * k + 3)));
    },
    get layers() {
      return pair.layers.map(({ name, kind, colour, points }) => ({
        name, kind, colour, pixels: Array.from({ length: points.length / 3 }, (_, k) => project(points.slice(3 * k, 3 * k + 3))),
      }));
    },
    get status() { return pair.status; },
    get pair() { return state.pair; },
    get pairCount() { return DATA.pairs.length; },
    get partCount() { return whole ? whole.bodies.length : 0; },
    get scale() { return $("triad").lastElementChild.textContent; },
    step, showPart, lookAtAll,
    get objects() { return objects(); },
    get camera() { return [...camera.position.toArray(), ...(controls?.target.toArray() ?? [])]; },
    get joints() { return shownJoints.map(({ k }) => ({ name: JOINTS[k].name, unit: JOINTS[k].unit, value: jointValue(k) })); },
    get byHand() { return state.byHand !== null; },
    pose: (which) => [...poseOf(pair.bodies[which])],
    centrePixel: (which) => project(apply(poseOf(pair.bodies[which]), [0, 0, 0])),
    setTime: stopAt, play: () => play(true), pause: () => play(false), toContact, resetView, lookAtContact,
  };

  setUpStage();
  setUpAssembly();
  setUpControls();
  choosePair(0);
  readHash();
})();
