using System;
using System.IO;
using System.Net.WebSockets;
using System.Threading;

namespace HaloTouch.Internal
{
    // The WebSocket of a service, received in a thread of its own; for the editor and desktop builds.
    // .NET's client allocates some objects for each message: use OSC where that matters.
    sealed class WebSocketInput : IInput
    {
        const int LargestBytes = 65507;
        const int RetryMs = 500;
        const string Subprotocol = "halo.1.osc";

        readonly Uri _url;
        readonly Thread _thread;
        readonly DatagramRing _ring = new DatagramRing();
        readonly byte[] _buffer = new byte[LargestBytes];
        readonly CancellationTokenSource _end = new CancellationTokenSource();
        volatile string _problem = "";

        public WebSocketInput(string url)
        {
            _url = new Uri(url);
            _thread = new Thread(Run) { IsBackground = true, Name = "halo" };
            _thread.Start();
        }

        public bool IsEnded => false;

        public string Problem => _problem;

        public bool TryReceive(ref byte[] buffer, out int length, out double receivedS) =>
            _ring.TryPop(ref buffer, out length, out receivedS);

        public void Dispose()
        {
            _end.Cancel();
            _thread.Join();
        }

        void Run()
        {
            while (!_end.IsCancellationRequested)
            {
                try
                {
                    using (var socket = new ClientWebSocket()) Receive(socket);
                    _problem = "the service at " + _url + " has closed the connection";
                }
                catch (Exception error) when (IsOfNetwork(error))
                {
                    _problem = "no connection to " + _url + " (" + error.GetBaseException().Message + ")";
                }
                _end.Token.WaitHandle.WaitOne(RetryMs);
            }
        }

        static bool IsOfNetwork(Exception error) =>
            error is AggregateException || error is OperationCanceledException ||
            error is WebSocketException || error is IOException || error is InvalidOperationException;

        void Receive(ClientWebSocket socket)
        {
            socket.Options.AddSubProtocol(Subprotocol);
            socket.ConnectAsync(_url, _end.Token).Wait(_end.Token);
            _problem = "";
            var length = 0;
            while (socket.State == WebSocketState.Open)
            {
                var room = new ArraySegment<byte>(_buffer, length, LargestBytes - length);
                var received = socket.ReceiveAsync(room, _end.Token);
                received.Wait(_end.Token);
                length += received.Result.Count;
                if (!received.Result.EndOfMessage && length < LargestBytes) continue;
                if (!received.Result.EndOfMessage) return; // Too large for a datagram: start again.
                if (received.Result.MessageType == WebSocketMessageType.Binary)
                    _ring.Push(_buffer, length, Clock.NowS);
                length = 0;
            }
        }
    }
}
