using System;
using System.Diagnostics;

namespace HaloTouch.Internal
{
    // A source of datagrams.
    interface IInput : IDisposable
    {
        // The next datagram and when it arrived, in seconds on the clock of `Clock`. The buffer can
        // be exchanged for another one. False if there is none now.
        bool TryReceive(ref byte[] buffer, out int length, out double receivedS);

        // What is wrong now, in one sentence; else empty.
        string Problem { get; }

        // Whether a recording is over.
        bool IsEnded { get; }
    }

    static class Clock
    {
        // Seconds on a monotonic clock.
        public static double NowS => Stopwatch.GetTimestamp() / (double)Stopwatch.Frequency;
    }

    // An input that cannot be opened, or a file that cannot be read; the message says what to do.
    sealed class InputException : Exception
    {
        public InputException(string message) : base(message)
        {
        }
    }
}
