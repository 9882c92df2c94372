// Browsers refuse web workers to pages that are opened from a folder (file://), and the search of the site is one.
// On such pages a Worker is a hidden iframe: its script runs in the page's thread, and messages become events of its
// window. The theme's `offline` plugin would fetch such a shim from the network whenever a page is read.
if (location.protocol === "file:") {
  const load = (inside, source) =>
    new Promise((done, failed) => {
      const script = Object.assign(inside.document.createElement("script"), { src: source, onload: done, onerror: failed })
      inside.document.body.append(script)
    })

  window.IFrameWorker = class extends EventTarget {
    constructor(url) {
      super()
      this.frame = Object.assign(document.createElement("iframe"), { hidden: true })
      const loaded = new Promise((done) => this.frame.addEventListener("load", done, { once: true }))
      document.body.append(this.frame)
      this.ready = loaded.then(() => {
        const inside = this.frame.contentWindow
        inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }))
        inside.importScripts = (...urls) => urls.reduce((before, each) => before.then(() => load(inside, each)), loaded)
        return load(inside, new URL(url, location.href).href)
      })
    }

    postMessage(data) {
      const inside = this.frame.contentWindow
      this.ready = this.ready.then(() => inside.dispatchEvent(new inside.MessageEvent("message", { data })))
    }

    terminate() {
      this.frame.remove()
    }
  }
  window.Worker = window.IFrameWorker
}
