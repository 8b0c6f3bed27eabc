// The browser's WebSocket for WebGL builds: C# reads messages when it wants them. The queue is bounded
// and drops the oldest, because each message is complete.
mergeInto(LibraryManager.library, {
  $haloSockets: { last: 0, all: {} },

  HaloSocketOpen: function (url) {
    var entry = { messages: [], socket: null };
    var id = ++haloSockets.last;
    haloSockets.all[id] = entry;
    try {
      entry.socket = new WebSocket(UTF8ToString(url), ["halo.1.osc"]);
    } catch (error) {
      console.error("halo: " + error); // The URL is invalid; the state is "closed".
      return id;
    }
    entry.socket.binaryType = "arraybuffer";
    entry.socket.onmessage = function (event) {
      if (!(event.data instanceof ArrayBuffer)) return;
      if (entry.messages.length === 128) entry.messages.shift();
      entry.messages.push(new Uint8Array(event.data));
    };
    return id;
  },
  HaloSocketOpen__deps: ["$haloSockets"],

  // 0 connecting, 1 open, 2 closing, 3 closed.
  HaloSocketState: function (id) {
    var entry = haloSockets.all[id];
    return entry && entry.socket ? entry.socket.readyState : 3;
  },
  HaloSocketState__deps: ["$haloSockets"],

  // Copies the oldest message; its length, or 0 if there is none. Messages that are too long are skipped.
  HaloSocketReceive: function (id, buffer, capacity) {
    var entry = haloSockets.all[id];
    while (entry && entry.messages.length > 0) {
      var message = entry.messages.shift();
      if (message.length > capacity) continue;
      HEAPU8.set(message, buffer);
      if (message.length > 0) return message.length;
    }
    return 0;
  },
  HaloSocketReceive__deps: ["$haloSockets"],

  HaloSocketClose: function (id) {
    var entry = haloSockets.all[id];
    delete haloSockets.all[id];
    if (entry && entry.socket) {
      entry.socket.onmessage = null;
      entry.socket.close();
    }
  },
  HaloSocketClose__deps: ["$haloSockets"],
});
