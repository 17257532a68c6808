// Work that is asked for faster than it is done, such as the picture at the cursor while it moves. One at a time; only the newest request counts.

export class Latest {
  /// @param work  async (request, signal) => anything; its errors go to `failed`
  constructor(work, failed = () => {}) {
    this.work = work;
    this.failed = failed;
    this.running = false;
    this.next = null;
    this.abort = new AbortController();
  }

  ask(request) {
    this.next = { request };
    if (!this.running) this.#run();
  }

  async #run() {
    this.running = true;
    while (this.next && !this.abort.signal.aborted) {
      const { request } = this.next;
      this.next = null;
      try {
        await this.work(request, this.abort.signal);
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
