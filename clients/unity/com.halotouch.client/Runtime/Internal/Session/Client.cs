using System;
using System.IO;

namespace HaloTouch.Internal
{
    // An input and the session that reads it; to be polled by the main thread.
    sealed class Client : IDisposable
    {
        const double TickS = 0.25; // how often lost services are detected while nothing arrives
        const int MaxDatagrams = 512; // in one poll: a flood must not stop the caller

        readonly IInput _input;
        byte[] _buffer = new byte[2048];
        double _nextTickS;
        bool _ended;
        bool _disposed; // a listener can close the client

        public Client(IInput input, in Follow follow, ISessionListener listener)
        {
            _input = input;
            Session = new Session(in follow, listener);
        }

        // InputException if the source is unknown or cannot be opened.
        public static Client Open(string url, ISessionListener listener)
        {
            var source = Source.Parse(url);
            return new Client(OpenInput(source), source.Follow, listener);
        }

        // A recorded stream as text, again and again if `loop`.
        public static Client OpenRecording(string text, string name, bool loop, ISessionListener listener)
        {
            var input = new RecordedInput(() => new StringReader(text), name, loop);
            return new Client(input, default(Follow), listener);
        }

        static IInput OpenInput(Source source)
        {
#if UNITY_WEBGL && !UNITY_EDITOR
            if (source.Kind == SourceKind.WebSocket) return new WebGlInput(source.Url);
            throw new InputException("a web page has no UDP and no files: use ws://127.0.0.1:4258/halo");
#else
            if (source.Kind == SourceKind.WebSocket) return new WebSocketInput(source.Url);
            if (source.Kind == SourceKind.Osc) return new UdpInput(source);
            return new RecordedInput(() => new StreamReader(source.Path), source.Path, false);
#endif
        }

        public Session Session { get; }

        // What is wrong with the input now, or empty.
        public string Problem => _input.Problem;

        public bool IsEnded => _ended;

        // Reports all events that have arrived. It allocates nothing.
        public void Poll()
        {
            for (var i = 0; i < MaxDatagrams && !_disposed; i++)
            {
                if (!_input.TryReceive(ref _buffer, out var length, out var receivedS)) break;
                Session.Receive(_buffer, length, receivedS);
            }
            if (!_disposed) Tick(Clock.NowS);
        }

        public void Dispose()
        {
            if (_disposed) return;
            _disposed = true;
            _input.Dispose();
            End();
        }

        void Tick(double nowS)
        {
            if (_input.IsEnded || _input is RecordedInput recorded && recorded.IsRestarted) End();
            _ended = _input.IsEnded;
            if (nowS < _nextTickS) return;
            _nextTickS = nowS + TickS;
            Session.Expire(nowS);
        }

        // Open touches end, and all services are lost.
        void End()
        {
            if (!_ended) Session.Expire(double.PositiveInfinity);
        }
    }
}
