// Shapes as triangles, as solids to be near to, and as targets of a ray.

const identity = [1, 0, 0, 0];

// Points of a half circle from pole to pole, with the side on which each half of a capsule lies.
function profile(kind, size, steps = 8) {
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

// A box with half lengths, its edges cut off by `edge` so that they catch the light.
function boxed([x, y, z], edge = Math.min(x, y, z) * 0.08) {
  const half = [x, y, z];
  const vertices = [];
  const quad = (corners, normal) => {
    const [a, b, c] = corners;
    const [e, f] = [b.map((v, k) => v - a[k]), c.map((v, k) => v - a[k])];
    const turned = dot(cross(e, f), normal) < 0;
    const order = turned ? [0, 2, 1, 0, 3, 2] : [0, 1, 2, 0, 2, 3];
    const length = Math.hypot(...normal);
    for (const k of order) {
      if (k < corners.length) vertices.push(...corners[k], ...normal.map((v) => v / length));
    }
  };
  const signs = [-1, 1];
  for (let axis = 0; axis < 3; axis++) {
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    const at = (along, across, deep) => {
      const place = [0, 0, 0];
      [place[axis], place[u], place[v]] = [along, across, deep];
      return place;
    };
    const [m, n] = [half[u] - edge, half[v] - edge];
    for (const side of signs) {
      const normal = at(side, 0, 0);
      quad([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => at(side * half[axis], a * m, b * n)), normal);
      // The cut edge towards u, along v.
      for (const other of signs) {
        const high = [side * half[axis], other * m];
        const low = [side * (half[axis] - edge), other * half[u]];
        quad([[high, -n], [high, n], [low, n], [low, -n]].map(([[p, q], r]) => at(p, q, r)), at(side, other, 0));
      }
    }
  }
  for (const a of signs) for (const b of signs) for (const c of signs) {
    const [i, j, k] = [half[0] - edge, half[1] - edge, half[2] - edge];
    const corners = [[a * x, b * j, c * k], [a * i, b * y, c * k], [a * i, b * j, c * z]];
    const normal = [a, b, c];
    const turned = dot(cross(corners[1].map((v, m) => v - corners[0][m]), corners[2].map((v, m) => v - corners[0][m])), normal) < 0;
    for (const m of turned ? [0, 2, 1] : [0, 1, 2]) vertices.push(...corners[m], ...normal.map((v) => v * 0.577));
  }
  return vertices;
}

const SECTORS = 28;

// A tube along points (x, y, z, radius): straight runs are turned on a lathe, bends are balls.
// Its ends are balls too, or flat with an edge cut off.
function tubed(points, isFlat) {
  const vertices = [];
  const place = (i) => points.slice(i * 4, i * 4 + 3);
  const count = points.length / 4;
  const ball = (i) => {
    const middle = place(i);
    const own = revolved(profile("sphere", [points[i * 4 + 3]], 5), SECTORS);
    for (let k = 0; k < own.length; k += 6) {
      vertices.push(own[k] + middle[0], own[k + 1] + middle[1], own[k + 2] + middle[2]);
      vertices.push(own[k + 3], own[k + 4], own[k + 5]);
    }
  };
  const way = (i) => {
    const step = place(i + 1).map((v, k) => v - points[i * 4 + k]);
    const length = Math.hypot(...step);
    return { length, along: step.map((v) => v / (length || 1)) };
  };
  if (count === 1) ball(0);
  let first = 0;
  while (first < count - 1) {
    // A run goes on as long as the points lie in one line.
    const { along } = way(first);
    let last = first + 1;
    while (last < count - 1 && dot(way(last).along, along) > 0.9999) last++;
    const rings = [];
    let far = 0;
    for (let i = first; i <= last; i++) {
      rings.push([points[i * 4 + 3], far]);
      if (i < last) far += way(i).length;
    }
    const lathe = [];
    const line = ([r0, z0], [r1, z1]) => {
      const [nr, nz] = [z1 - z0, r0 - r1];
      if (nr || nz) lathe.push([r0, z0, nr, nz], [r1, z1, nr, nz]);
    };
    const cap = (ring, side) => {
      const edge = Math.min(ring[0] * 0.12, 0.006, far / 3);
      const rim = [ring[0] - edge, ring[1]];
      const inner = [ring[0], ring[1] - side * edge];
      if (side < 0) {
        line([0, ring[1]], rim);
        line(rim, inner);
      } else {
        line(inner, rim);
        line(rim, [0, ring[1]]);
      }
      return inner;
    };
    const inner = rings.map((ring) => ring);
    const [isFirst, isLast] = [first === 0, last === count - 1];
    if (isFirst && isFlat) inner[0] = cap(rings[0], -1);
    for (let i = 0; i + 1 < inner.length; i++) {
      const to = i + 2 === inner.length && isLast && isFlat
        ? [inner[i + 1][0], inner[i + 1][1] - Math.min(inner[i + 1][0] * 0.12, 0.006, far / 3)]
        : inner[i + 1];
      line(inner[i], to);
    }
    if (isLast && isFlat) cap(rings.at(-1), 1);
    const turn = turnTo(along);
    const begin = place(first);
    const own = revolved(lathe, SECTORS);
    for (let k = 0; k < own.length; k += 6) {
      const p = rotate(turn, [own[k], own[k + 1], own[k + 2]]);
      vertices.push(p[0] + begin[0], p[1] + begin[1], p[2] + begin[2]);
      vertices.push(...rotate(turn, [own[k + 3], own[k + 4], own[k + 5]]));
    }
    if (!isFirst || !isFlat) ball(first);
    if (isLast && !isFlat) ball(last);
    first = last;
  }
  return vertices;
}

// The turn that brings the z axis to a direction.
function turnTo([x, y, z]) {
  const across = Math.hypot(x, y);
  if (across < 1e-9) return z < 0 ? [0, 1, 0, 0] : identity;
  return about([-y / across, x / across, 0], Math.acos(Math.min(Math.max(z, -1), 1)));
}

// Triangles as they come, nine numbers each, with the normal of each.
function faceted(flat) {
  const vertices = [];
  for (let i = 0; i < flat.length; i += 9) {
    const [a, b, c] = [flat.slice(i, i + 3), flat.slice(i + 3, i + 6), flat.slice(i + 6, i + 9)];
    const n = cross(b.map((v, k) => v - a[k]), c.map((v, k) => v - a[k]));
    const length = Math.hypot(...n) || 1;
    for (const corner of [a, b, c]) vertices.push(...corner, ...n.map((v) => v / length));
  }
  return vertices;
}

// A mesh as `coarse.py` packed it: faces that meet at a small angle are smooth.
function unpackedMesh(packed) {
  const bytes = Uint8Array.from(atob(packed), (character) => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  const [count, faces] = [view.getUint32(0, true), view.getUint32(4, true)];
  const quantum = view.getFloat32(8, true);
  const at = (i) => [0, 1, 2].map((k) => view.getInt16(12 + 6 * i + 2 * k, true) * quantum);
  const places = Array.from({ length: count }, (_, i) => at(i));
  const corner = (face, k) => view.getUint16(12 + 6 * count + 6 * face + 2 * k, true);
  const normals = [];
  const meeting = places.map(() => []);
  for (let face = 0; face < faces; face++) {
    const [a, b, c] = [0, 1, 2].map((k) => places[corner(face, k)]);
    // As long as twice the face is large: large ones count for more.
    normals.push(cross(b.map((v, k) => v - a[k]), c.map((v, k) => v - a[k])));
    for (let k = 0; k < 3; k++) meeting[corner(face, k)].push(face);
  }
  const lengths = normals.map((n) => Math.hypot(...n) || 1);
  const vertices = [];
  for (let face = 0; face < faces; face++) {
    for (let k = 0; k < 3; k++) {
      const sum = [0, 0, 0];
      for (const other of meeting[corner(face, k)]) {
        const cosine = dot(normals[face], normals[other]) / lengths[face] / lengths[other];
        if (cosine > 0.7) for (let m = 0; m < 3; m++) sum[m] += normals[other][m];
      }
      const length = Math.hypot(...sum) || 1;
      vertices.push(...places[corner(face, k)], ...sum.map((v) => v / length));
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
  return new Float32Array([...vertices, ...faceted(body.triangles ?? [])]);
}

// What is drawn of a body: a mesh for each paint, joints apart. Where nothing is made for drawing, its shapes are.
function drawnMeshes(body) {
  if (!body.look) return [{ paint: null, isJoint: false, mesh: bodyMesh(body) }];
  const alike = new Map();
  for (const piece of body.look) {
    const { paint = null, joint: isJoint = false } = piece;
    let own;
    if (piece.tube) own = tubed(piece.tube, piece.flat);
    else {
      const { mesh, box, edge, xyz, quat = identity } = { xyz: [0, 0, 0], ...piece };
      own = mesh ? unpackedMesh(mesh) : boxed(box, edge);
      for (let i = 0; i < own.length; i += 6) {
        const p = rotate(quat, own.slice(i, i + 3));
        const n = rotate(quat, own.slice(i + 3, i + 6));
        for (let k = 0; k < 3; k++) {
          own[i + k] = p[k] + xyz[k];
          own[i + 3 + k] = n[k];
        }
      }
    }
    const key = `${paint} ${isJoint}`;
    if (!alike.has(key)) alike.set(key, { paint, isJoint, all: [] });
    const { all } = alike.get(key);
    for (const value of own) all.push(value);
  }
  return [...alike.values()].map(({ paint, isJoint, all }) => ({ paint, isJoint, mesh: new Float32Array(all) }));
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
