// Work that is asked for faster than it is done, such as the picture at the cursor while it moves. One at a time; only the newest wish counts.

export class Latest {
  /// @param work  async (wish, signal) => anything; its errors go to `failed`
  constructor(work, failed = () => {}) {
    this.work = work;
    this.failed = failed;
    this.running = false;
    this.next = null;
    this.abort = new AbortController();
  }

  ask(wish) {
    this.next = { wish };
    if (!this.running) this.#run();
  }

  async #run() {
    this.running = true;
    while (this.next && !this.abort.signal.aborted) {
      const { wish } = this.next;
      this.next = null;
      try {
        await this.work(wish, this.abort.signal);
      } catch (error) {
        if (!this.abort.signal.aborted) this.failed(error);
      }
    }
    this.running = false;
  }

  get stopped() {
    return this.abort.signal.aborted;
  }

  stop() {
    this.abort.abort();
  }
}
