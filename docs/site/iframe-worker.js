/* Browsers refuse to start a worker for a page that was opened as a file. The search then runs in a hidden
   frame, which has the interface of a worker. The name is the one by which MkDocs's plugin "offline"
   recognises such a script, and doesn't load another one from the network. */
(function () {
  "use strict";
  if (location.protocol !== "file:") return;

  class FrameWorker extends EventTarget {
    constructor(url) {
      super();
      this.onmessage = null;
      this.onerror = null;
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.appendChild(frame);
      this.frame = frame;
      this.inner = frame.contentWindow;
      this.listener = (event) => {
        if (event.source !== this.inner) return;
        const message = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(message);
        if (this.onmessage) this.onmessage(message);
      };
      window.addEventListener("message", this.listener);
      this.ready = new Promise((resolve) => { this.resolve = resolve; });
      const page = this.inner.document;
      page.open();
      page.write(
        "<html><body><script>" +
        "postMessage = function (data) { parent.postMessage(data, '*'); };" +
        "importScripts = function () {" +
        "  return Array.prototype.reduce.call(arguments, function (before, url) {" +
        "    return before.then(function () { return new Promise(function (resolve) {" +
        "      var script = document.createElement('script');" +
        "      script.src = url; script.onload = resolve; document.body.appendChild(script);" +
        "    }); });" +
        "  }, Promise.resolve());" +
        "};" +
        "<\/script><script src=\"" + url + "\"><\/script></body></html>");
      page.close();
      this.inner.addEventListener("load", this.resolve);
    }
    postMessage(data) {
      this.ready.then(() => this.inner.dispatchEvent(new MessageEvent("message", { data: data })));
    }
    terminate() {
      this.frame.remove();
      window.removeEventListener("message", this.listener);
    }
  }
  window.Worker = FrameWorker;
})();
