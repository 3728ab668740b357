// A mesh of 64 × 64 quadrilaterals in 200 states, whose height is the value that colours it.
const N = 64, P = (N + 1) * (N + 1), STATES = 200, ref = new Float32Array(3 * P), quads = [];
for (let j = 0; j <= N; j++) for (let i = 0; i <= N; i++) ref.set([i / N - 0.5, j / N - 0.5, 0], 3 * (j * (N + 1) + i));
for (let j = 0; j < N; j++)
  for (let i = 0; i < N; i++) {
    const a = j * (N + 1) + i;
    quads.push(a, a + 1, a + N + 2, a + N + 1);
  }
const height = (t, p) => 0.2 * Math.sin(6.3 * (ref[3 * p] + t / STATES)) * Math.cos(3 * ref[3 * p + 1]);
const zs = Array.from({ length: STATES }, (_, t) => Float32Array.from({ length: P }, (_, p) => height(t, p)));

/** Makes the page ready for `bench(n, done)`, which hands the times of n + 1 pictures to `done`. */
function loop(show) {
  window.bench = (n, done) => {
    const times = [];
    const picture = (now) => {
      times.push(now);
      if (times.length > n) return done(times);
      show(times.length % STATES);
      requestAnimationFrame(picture);
    };
    requestAnimationFrame(picture);
  };
}
