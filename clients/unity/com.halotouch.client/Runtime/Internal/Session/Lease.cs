using System.Text;

namespace HaloTouch.Internal
{
    enum LeaseState { Asking, Streaming, Refused }

    // Asks a service for its stream, and asks again before the lease ends. Pure: datagrams and times
    // are arguments; a socket sends what `Due` writes.
    sealed class Lease
    {
        public const string Version = "1.0.0";

        const double HelloS = 1.0; // a service that starts later is found within a second
        const double LeaseS = 3.0; // a service ends a stream after 10 s without one
        const int LeastHello = 256; // no answer is larger than its question
        const int MaxToken = 256;
        const string Root = "/halo/1/control/";

        readonly string _stream;
        readonly int _port;
        readonly OscWriter _writer = new OscWriter();
        string _token = "";
        double _nextS = double.NegativeInfinity;

        // `port`: where the stream is received.
        public Lease(string stream, int port)
        {
            _stream = stream;
            _port = port;
        }

        public LeaseState State { get; private set; }

        // Why the service refuses, else empty.
        public string Reason { get; private set; } = "";

        // Whether the service has a newer minor version: it sends more than this client reads.
        public bool IsOutdated { get; private set; }

        // The hello or lease to send now, or null.
        public OscWriter Due(double nowS)
        {
            if (nowS < _nextS || State == LeaseState.Refused) return null;
            _nextS = nowS + (State == LeaseState.Streaming ? LeaseS : HelloS);
            return State == LeaseState.Streaming ? WithToken("lease") : Hello();
        }

        // The message that ends the stream, or null.
        public OscWriter Goodbye() => State == LeaseState.Streaming ? WithToken("goodbye") : null;

        OscWriter Hello()
        {
            _writer.Start().Message(Root + "hello", ",ssis").Text(Version).Text(_stream).Int(_port);
            var missing = LeastHello - 4 - _writer.Length;
            return _writer.Text(new string('.', missing > 0 ? missing : 0));
        }

        OscWriter WithToken(string kind) =>
            _writer.Start().Message(Root + kind, ",s").Text(_token);

        // Processes an answer of the control port; all else is ignored.
        public void Handle(byte[] bytes, int length)
        {
            var reader = new OscReader(bytes, 0, length);
            reader.Text(out var start, out var stop);
            if (reader.Error != null) return;
            if (Ascii.Equal(bytes, start, stop, Root + "welcome")) HandleWelcome(ref reader, bytes);
            else if (Ascii.Equal(bytes, start, stop, Root + "expired")) HandleExpired(ref reader, bytes);
        }

        void HandleWelcome(ref OscReader reader, byte[] bytes)
        {
            reader.Tags(",ssssss");
            for (var i = 0; i < 3; i++) reader.Text(out _, out _); // node, session, version
            var outcome = ReadText(ref reader, bytes);
            var token = ReadText(ref reader, bytes);
            var reason = ReadText(ref reader, bytes);
            if (reader.Error != null) return;
            if (outcome == "refused")
            {
                State = LeaseState.Refused;
                Reason = reason;
            }
            else if (State == LeaseState.Asking && token.Length > 0)
            {
                IsOutdated = outcome == "warned";
                Renew(token);
            }
        }

        void HandleExpired(ref OscReader reader, byte[] bytes)
        {
            reader.Tags(",s");
            var token = ReadText(ref reader, bytes);
            if (reader.Error == null && State == LeaseState.Streaming && token == _token) Renew("");
        }

        // Uses a token; without one, says hello again.
        void Renew(string token)
        {
            _token = token;
            State = token.Length > 0 ? LeaseState.Streaming : LeaseState.Asking;
            _nextS = double.NegativeInfinity;
        }

        static string ReadText(ref OscReader reader, byte[] bytes)
        {
            reader.Text(out var start, out var stop);
            if (stop - start > MaxToken) stop = start + MaxToken;
            return Encoding.UTF8.GetString(bytes, start, stop - start);
        }
    }
}
