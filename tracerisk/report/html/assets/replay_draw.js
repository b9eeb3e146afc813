// Draws bodies with WebGL2: light from above, soft shadows, a ground that fades away.

const SHADOW = 1024;
const BUTTONS = 46; // what they cover at the top of the picture [px]
const LIGHT = (() => {
  const way = [0.35, -0.5, 0.8];
  const length = Math.hypot(...way);
  return way.map((each) => each / length);
})();

const SHADE = `
  uniform highp sampler2DShadow shadows;
  uniform vec3 light;
  float lit(vec4 at) {
    vec3 p = at.xyz / at.w * 0.5 + 0.5;
    if (p.x < 0.0 || p.x > 1.0 || p.y < 0.0 || p.y > 1.0 || p.z > 1.0) return 1.0;
    float sum = 0.0;
    for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++)
      sum += texture(shadows, p + vec3(vec2(i, j) * ${(1.2 / SHADOW).toFixed(6)}, -0.0012));
    return sum / 25.0;
  }
  vec3 shown(vec3 linear) { return pow(clamp(linear, 0.0, 1.0), vec3(1.0 / 2.2)); }`;

const BODY_VERTEX = `#version 300 es
  uniform mat4 model, view, sun;
  layout(location = 0) in vec3 position;
  layout(location = 1) in vec3 normal;
  out vec3 facing, place;
  out vec4 inSun;
  void main() {
    vec4 at = model * vec4(position, 1.0);
    facing = mat3(model) * normal;
    place = at.xyz;
    inSun = sun * at;
    gl_Position = view * at;
  }`;

const BODY_FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 facing, place;
  in vec4 inSun;
  uniform vec3 colour, eye, glowing;
  uniform float plain, glow;
  out vec4 result;
  ${SHADE}
  void main() {
    vec3 base = pow(colour, vec3(2.2));
    vec3 n = normalize(facing), v = normalize(eye - place);
    float sun = max(dot(n, light), 0.0);
    if (sun > 0.0) sun *= lit(inSun);
    float sky = 0.5 + 0.5 * n.z;
    float fill = max(dot(n, normalize(vec3(-light.x, -light.y, 0.35))), 0.0);
    float shine = pow(max(dot(n, normalize(light + v)), 0.0), 48.0) * 0.22 * sun;
    float front = max(dot(n, v), 0.0);
    // Edges are darker: a white arm stands out from a white page.
    float edge = 1.0 - 0.45 * pow(1.0 - front, 3.0);
    vec3 shaded = base * (mix(0.2, 0.46, sky) + 0.62 * sun + 0.14 * fill) * edge + shine;
    shaded += pow(glowing, vec3(2.2)) * glow * (0.1 + 0.3 * pow(1.0 - front, 2.0));
    result = vec4(shown(mix(shaded, base, plain)), 1.0);
  }`;

const GROUND_FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 facing, place;
  in vec4 inSun;
  uniform vec3 colour, background, eye;
  uniform vec4 middle;
  out vec4 result;
  ${SHADE}
  float lines(float size) {
    vec2 at = place.xy / size, width = fwidth(at) * 1.2;
    vec2 near = abs(fract(at - 0.5) - 0.5) / max(width, vec2(1e-6));
    float fine = 1.0 - clamp(max(width.x, width.y) * 3.0, 0.0, 1.0);
    return (1.0 - min(min(near.x, near.y), 1.0)) * fine;
  }
  void main() {
    float away = length(place.xy - middle.xy) / middle.w;
    float here = 1.0 - smoothstep(0.9, 3.2, away);
    vec3 base = pow(colour, vec3(2.2)), behind = pow(background, vec3(2.2));
    float shade = mix(0.5, 1.0, lit(inSun));
    vec3 floored = base * shade;
    floored = mix(floored, floored * 0.8, max(lines(0.1) * 0.5, lines(0.5)));
    result = vec4(shown(mix(behind, floored, here)), 1.0);
  }`;

// A shell around what glows, which fades outwards.
const HALO_VERTEX = `#version 300 es
  uniform mat4 model, view;
  uniform float wide;
  layout(location = 0) in vec3 position;
  layout(location = 1) in vec3 normal;
  out vec3 facing, place;
  void main() {
    vec4 at = model * vec4(position + normal * wide, 1.0);
    facing = mat3(model) * normal;
    place = at.xyz;
    gl_Position = view * at;
  }`;

const HALO_FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 facing, place;
  uniform vec3 eye, glowing;
  uniform float glow;
  out vec4 result;
  void main() {
    float near = max(dot(normalize(facing), normalize(eye - place)), 0.0);
    result = vec4(glowing, 0.34 * glow * pow(near, 1.8));
  }`;

const SHADOW_VERTEX = `#version 300 es
  uniform mat4 model, sun;
  layout(location = 0) in vec3 position;
  void main() { gl_Position = sun * model * vec4(position, 1.0); }`;

const SHADOW_FRAGMENT = `#version 300 es
  precision highp float;
  void main() {}`;

class Drawing {
  constructor(canvas, meshes, bounds) {
    const wanted = { antialias: true, alpha: false, preserveDrawingBuffer: true };
    const gl = canvas.getContext("webgl2", wanted);
    if (!gl) throw new Error("no WebGL2");
    this.gl = gl;
    this.canvas = canvas;
    this.meshes = meshes;
    this.bounds = bounds;
    this.prepare();
  }
  // All that a lost context takes with it.
  prepare() {
    const { gl } = this;
    // All are begun before the first is asked for: drivers compile several at once.
    const begun = [
      [BODY_VERTEX, BODY_FRAGMENT], [BODY_VERTEX, GROUND_FRAGMENT],
      [SHADOW_VERTEX, SHADOW_FRAGMENT], [HALO_VERTEX, HALO_FRAGMENT],
    ].map(([vertex, fragment]) => this.program(vertex, fragment));
    this.buffers = this.meshes.map((mesh) => this.upload(mesh));
    const far = this.bounds.radius * 14;
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]];
    const { centre, floor } = this.bounds;
    this.plane = this.upload(
      new Float32Array(
        corners.flatMap(([x, y]) => [centre[0] + x * far, centre[1] + y * far, floor, 0, 0, 1]),
      ),
    );
    this.shadows = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadows);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW, SHADOW);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    this.target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(
      gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadows, 0,
    );
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.enable(gl.DEPTH_TEST);
    [this.body, this.ground, this.caster, this.halo] = begun.map((one) => this.linked(one));
  }
  upload(mesh) {
    const { gl } = this;
    const vertexArray = gl.createVertexArray();
    gl.bindVertexArray(vertexArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, mesh, gl.STATIC_DRAW);
    for (const slot of [0, 1]) {
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 24, slot * 12);
    }
    return { vertexArray, count: mesh.length / 6 };
  }
  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return program;
  }
  linked(program) {
    const { gl } = this;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const shaders = gl.getAttachedShaders(program).map((each) => gl.getShaderInfoLog(each));
      throw new Error(`${gl.getProgramInfoLog(program)} ${shaders.join(" ")}`);
    }
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }
  fit() {
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const width = Math.max(Math.round(this.canvas.clientWidth * ratio), 1);
    const height = Math.max(Math.round(this.canvas.clientHeight * ratio), 1);
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    return width / height;
  }
  sun() {
    const { centre, radius } = this.bounds;
    const reach = radius * 1.5;
    const right = [-LIGHT[1], LIGHT[0], 0].map((v) => v / Math.hypot(LIGHT[0], LIGHT[1]));
    const up = [
      LIGHT[1] * right[2] - LIGHT[2] * right[1],
      LIGHT[2] * right[0] - LIGHT[0] * right[2],
      LIGHT[0] * right[1] - LIGHT[1] * right[0],
    ];
    const eye = centre.map((v, i) => v + LIGHT[i] * reach * 2);
    const box = [1 / reach, 0, 0, 0, 0, 1 / reach, 0, 0, 0, 0, -0.5 / reach, 0, 0, 0, -1, 1];
    return product(box, looking(eye, right, up, LIGHT));
  }
  // `shown`: mesh, model matrix, colour and glow of each body, `plain` for what is not lit.
  draw(camera, shown, colours) {
    const { gl } = this;
    if (gl.isContextLost()) return;
    const view = camera.matrix(this.fit(), Math.min(BUTTONS / this.canvas.clientHeight, 0.2));
    const sun = this.sun();
    const casters = shown.filter((each) => !each.plain);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.caster.program);
    gl.uniformMatrix4fv(this.caster.places.sun, false, sun);
    for (const each of casters) this.mesh(this.caster, each);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...colours.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.bindTexture(gl.TEXTURE_2D, this.shadows);
    for (const use of [this.ground, this.body]) {
      gl.useProgram(use.program);
      gl.uniformMatrix4fv(use.places.view, false, view);
      gl.uniformMatrix4fv(use.places.sun, false, sun);
      gl.uniform3fv(use.places.light, LIGHT);
      if (use.places.eye) gl.uniform3fv(use.places.eye, camera.eye);
      if (use === this.ground) {
        const { centre, radius } = this.bounds;
        gl.uniform3fv(use.places.background, colours.background);
        gl.uniform4fv(use.places.middle, [...centre, radius]);
        gl.uniformMatrix4fv(use.places.model, false, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
        gl.uniform3fv(use.places.colour, colours.ground);
        gl.bindVertexArray(this.plane.vertexArray);
        gl.drawArrays(gl.TRIANGLES, 0, this.plane.count);
      }
    }
    // Links end in balls of one size at one place: an offset decides which of the two is seen.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    for (const each of casters) {
      gl.polygonOffset(0, -320 * (each.body % 4));
      this.mesh(this.body, each);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    this.haloes(casters.filter(({ glow }) => glow), camera, view);
    gl.disable(gl.DEPTH_TEST);
    for (const each of shown) if (each.plain) this.mesh(this.body, each);
    gl.enable(gl.DEPTH_TEST);
    return view;
  }
  haloes(glowing, camera, view) {
    const { gl } = this;
    gl.useProgram(this.halo.program);
    gl.uniformMatrix4fv(this.halo.places.view, false, view);
    gl.uniform3fv(this.halo.places.eye, camera.eye);
    gl.enable(gl.BLEND);
    gl.enable(gl.CULL_FACE);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniform1f(this.halo.places.wide, 0.03 * Math.min(this.bounds.radius, 1));
    for (const each of glowing) this.mesh(this.halo, each);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
    gl.useProgram(this.body.program);
  }
  mesh({ places }, { mesh, model, colour, plain = 0, glow = 0, glowing = colour }) {
    const { gl } = this;
    const { vertexArray, count } = this.buffers[mesh];
    gl.uniformMatrix4fv(places.model, false, model);
    if (places.colour) gl.uniform3fv(places.colour, colour);
    if (places.glow) gl.uniform1f(places.glow, glow);
    if (places.glowing) gl.uniform3fv(places.glowing, glowing);
    if (places.plain) gl.uniform1f(places.plain, plain);
    gl.bindVertexArray(vertexArray);
    gl.drawArrays(gl.TRIANGLES, 0, count);
  }
}
