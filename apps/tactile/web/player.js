// Plays a run: moves the cursor with the time that passes, slowed or quickened.

export const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 4];

/// The next slower (-1) or quicker (1) of SPEEDS.
export function otherSpeed(speed, direction) {
  const index = SPEEDS.indexOf(speed) + direction;
  return SPEEDS[Math.min(Math.max(index, 0), SPEEDS.length - 1)];
}

export class Player {
  constructor(state, speed, frame = (f) => requestAnimationFrame(f)) {
    this.state = state;
    this.speed = speed;
    this.frame = frame;
  }

  toggle() {
    if (this.state.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.state.at_us >= this.state.length_us) this.state.setAt(0);
    this.exact_us = this.state.at_us;
    this.last_ms = null;
    this.state.setPlaying(true);
    this.frame((now) => this.#step(now));
  }

  pause() {
    if (this.state.playing) this.state.setPlaying(false);
  }

  #step(now_ms) {
    if (!this.state.playing) return;
    if (Math.round(this.exact_us) !== this.state.at_us) this.exact_us = this.state.at_us; // a person moved the cursor meanwhile
    if (this.last_ms !== null) this.exact_us += (now_ms - this.last_ms) * 1000 * this.speed;
    this.last_ms = now_ms;
    this.state.setAt(this.exact_us);
    if (this.exact_us >= this.state.length_us) this.pause();
    else this.frame((next) => this.#step(next));
  }
}
