// Shapes as triangles, as solids to be near to, and as targets of a ray.

const identity = [1, 0, 0, 0];

// Points of a half circle from pole to pole, with the side on which each half of a capsule lies.
function profile(kind, size) {
  const [radius, half = 0] = size;
  const rings = [];
  if (kind === "cylinder") {
    const edge = Math.min(radius, half) * 0.08;
    rings.push([0, -half, 0, -1], [radius - edge, -half, 0, -1], [radius - edge, -half, 0.38, -0.92]);
    rings.push([radius, -half + edge, 0.92, -0.38], [radius, -half + edge, 1, 0]);
    rings.push([radius, half - edge, 1, 0], [radius, half - edge, 0.92, 0.38]);
    rings.push([radius - edge, half, 0.38, 0.92], [radius - edge, half, 0, 1], [0, half, 0, 1]);
    return rings;
  }
  const steps = 8;
  for (const side of [-1, 1]) {
    for (let i = 0; i <= steps; i++) {
      const angle = (side < 0 ? steps - i : i) * (Math.PI / 2 / steps);
      const [c, s] = [Math.cos(angle), side * Math.sin(angle)];
      rings.push([radius * c, radius * s + side * half, c, s]);
    }
  }
  return rings;
}

function revolved(rings, sectors = 36) {
  const vertices = [];
  const point = ([r, z, nr, nz], angle) => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const n = Math.hypot(nr, nz) || 1;
    return [r * c, r * s, z, (nr / n) * c, (nr / n) * s, nz / n];
  };
  for (let i = 0; i + 1 < rings.length; i++) {
    const [low, high] = [rings[i], rings[i + 1]];
    if (low[0] === high[0] && low[1] === high[1]) continue;
    for (let j = 0; j < sectors; j++) {
      const [a, b] = [(2 * Math.PI * j) / sectors, (2 * Math.PI * (j + 1)) / sectors];
      const corners = [point(low, a), point(low, b), point(high, b), point(high, a)];
      for (const k of [0, 1, 2, 0, 2, 3]) vertices.push(...corners[k]);
    }
  }
  return vertices;
}

function boxed([x, y, z]) {
  const vertices = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const side of [-1, 1]) {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => {
        const corner = [0, 0, 0];
        [corner[axis], corner[u], corner[v]] = [side, a * side, b];
        return corner;
      });
      const normal = [0, 0, 0];
      normal[axis] = side;
      for (const k of [0, 1, 2, 0, 2, 3]) {
        const [cx, cy, cz] = corners[k];
        vertices.push(cx * x, cy * y, cz * z, ...normal);
      }
    }
  }
  return vertices;
}

// The triangles of a body in its frame: x, y, z and normal of each corner.
function bodyMesh(body) {
  const vertices = [];
  for (const shape of body.shapes) {
    const { kind, size, xyz = [0, 0, 0], quat = identity } = shape;
    const own = kind === "box" ? boxed(size) : revolved(profile(kind, size));
    for (let i = 0; i < own.length; i += 6) {
      const p = rotate(quat, own.slice(i, i + 3));
      vertices.push(p[0] + xyz[0], p[1] + xyz[1], p[2] + xyz[2]);
      vertices.push(...rotate(quat, own.slice(i + 3, i + 6)));
    }
  }
  const flat = body.triangles ?? [];
  for (let i = 0; i < flat.length; i += 9) {
    const [a, b, c] = [flat.slice(i, i + 3), flat.slice(i + 3, i + 6), flat.slice(i + 6, i + 9)];
    const [e, f] = [b.map((v, k) => v - a[k]), c.map((v, k) => v - a[k])];
    const n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    const length = Math.hypot(...n) || 1;
    for (const corner of [a, b, c]) vertices.push(...corner, ...n.map((v) => v / length));
  }
  return new Float32Array(vertices);
}

// The point of a solid that is nearest to a point in the solid's own frame.
function nearestInShape({ kind, size }, p) {
  if (kind === "box") return p.map((v, i) => Math.min(Math.max(v, -size[i]), size[i]));
  const [radius, half = 0] = size;
  const z = Math.min(Math.max(p[2], -half), half);
  if (kind === "cylinder") {
    const r = Math.hypot(p[0], p[1]);
    const scale = r > radius ? radius / r : 1;
    return [p[0] * scale, p[1] * scale, z];
  }
  const away = [p[0], p[1], p[2] - z];
  const distance = Math.hypot(...away);
  const scale = distance > radius ? radius / distance : 1;
  return [away[0] * scale, away[1] * scale, z + away[2] * scale];
}

// The point of a body's shapes nearest to a point of the world; `null` for a body without shapes.
function nearestInBody(body, pose, point) {
  let best = null;
  const inside = toBody(pose, point);
  const consider = (p) => {
    const distance = Math.hypot(p[0] - inside[0], p[1] - inside[1], p[2] - inside[2]);
    if (best === null || distance < best.distance) best = { distance, point: p };
  };
  // What is only shown touches nothing.
  const solid = body.shapes.filter(({ contact }) => contact !== false);
  for (const shape of solid.length ? solid : body.shapes) {
    const own = { xyz: shape.xyz ?? [0, 0, 0], quat: shape.quat ?? identity };
    consider(toWorld(own, nearestInShape(shape, toBody(own, inside))));
  }
  const corners = body.triangles ?? [];
  for (let i = 0; i < corners.length; i += 3) consider(corners.slice(i, i + 3));
  return best && { distance: best.distance, point: toWorld(pose, best.point) };
}

// Where two bodies are nearest: each point in turn is brought to the other body.
function touchPoint(one, onePose, other, otherPose) {
  const pads = one.shapes.filter((each) => each.pad);
  const touching = pads.length ? { ...one, shapes: pads, triangles: [] } : one;
  let point = otherPose.xyz;
  let last = null;
  for (let turn = 0; turn < 60; turn++) {
    const mine = nearestInBody(touching, onePose, point);
    const theirs = mine && nearestInBody(other, otherPose, mine.point);
    if (!theirs) return mine ? mine.point : point;
    const middle = mine.point.map((v, i) => (v + theirs.point[i]) / 2);
    const moved = last ? Math.hypot(...middle.map((v, i) => v - last[i])) : Infinity;
    [last, point] = [middle, theirs.point];
    if (moved < 1e-6) break;
  }
  return last;
}

// How far along a ray (origin, direction in the mesh's frame) the mesh is hit; Infinity: nowhere.
function rayHit(mesh, origin, way) {
  let nearest = Infinity;
  for (let i = 0; i < mesh.length; i += 18) {
    const [ax, ay, az] = [mesh[i], mesh[i + 1], mesh[i + 2]];
    const [ux, uy, uz] = [mesh[i + 6] - ax, mesh[i + 7] - ay, mesh[i + 8] - az];
    const [vx, vy, vz] = [mesh[i + 12] - ax, mesh[i + 13] - ay, mesh[i + 14] - az];
    const [px, py, pz] = [
      way[1] * vz - way[2] * vy,
      way[2] * vx - way[0] * vz,
      way[0] * vy - way[1] * vx,
    ];
    const size = ux * px + uy * py + uz * pz;
    if (Math.abs(size) < 1e-15) continue;
    const [sx, sy, sz] = [origin[0] - ax, origin[1] - ay, origin[2] - az];
    const u = (sx * px + sy * py + sz * pz) / size;
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
    const v = (way[0] * qx + way[1] * qy + way[2] * qz) / size;
    if (v < 0 || u + v > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / size;
    if (distance > 1e-6 && distance < nearest) nearest = distance;
  }
  return nearest;
}
