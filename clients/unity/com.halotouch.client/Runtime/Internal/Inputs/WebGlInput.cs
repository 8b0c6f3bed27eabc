#if UNITY_WEBGL && !UNITY_EDITOR
using System.Runtime.InteropServices;

namespace HaloTouch.Internal
{
    // The WebSocket of a service in a WebGL build: the browser's, through HaloWebSocket.jslib. There
    // are no threads: messages wait in a bounded queue of the page.
    sealed class WebGlInput : IInput
    {
        const double RetryS = 0.5;
        const int LargestBytes = 65507;
        const int Closed = 3;

        [DllImport("__Internal")]
        static extern int HaloSocketOpen(string url);

        [DllImport("__Internal")]
        static extern int HaloSocketState(int socket);

        [DllImport("__Internal")]
        static extern int HaloSocketReceive(int socket, byte[] buffer, int capacity);

        [DllImport("__Internal")]
        static extern void HaloSocketClose(int socket);

        readonly string _url;
        int _socket;
        double _retryS;

        public WebGlInput(string url)
        {
            _url = url;
            _socket = HaloSocketOpen(url);
        }

        public bool IsEnded => false;

        public string Problem { get; private set; } = "";

        public bool TryReceive(ref byte[] buffer, out int length, out double receivedS)
        {
            receivedS = Clock.NowS;
            if (buffer.Length < LargestBytes) buffer = new byte[LargestBytes];
            length = HaloSocketReceive(_socket, buffer, buffer.Length);
            if (length > 0) Problem = "";
            else if (HaloSocketState(_socket) == Closed) Retry(receivedS);
            return length > 0;
        }

        public void Dispose()
        {
            HaloSocketClose(_socket);
        }

        void Retry(double nowS)
        {
            Problem = "no connection to " + _url;
            if (nowS < _retryS) return;
            _retryS = nowS + RetryS;
            HaloSocketClose(_socket);
            _socket = HaloSocketOpen(_url);
        }
    }
}
#endif
