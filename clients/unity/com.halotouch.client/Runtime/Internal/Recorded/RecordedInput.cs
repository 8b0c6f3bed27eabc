using System;
using System.IO;

namespace HaloTouch.Internal
{
    // A recorded stream at its own speed: scenes are built without a service. Reading a line
    // allocates.
    sealed class RecordedInput : IInput
    {
        readonly Func<TextReader> _open;
        readonly string _name;
        readonly bool _loop;
        readonly OscWriter _datagram = new OscWriter();
        TextReader _lines;
        int _number;
        bool _ready;
        double _startedS;
        double _dueS;
        long _firstUs = -1;

        // `open` starts at the first line; it is called again for each round of a loop.
        public RecordedInput(Func<TextReader> open, string name, bool loop)
        {
            _open = open;
            _name = name;
            _loop = loop;
            _lines = Open();
        }

        public bool IsEnded { get; private set; }

        // Whether the next datagram begins another round: the old session is over before it.
        public bool IsRestarted { get; private set; }

        public string Problem { get; private set; } = "";

        public bool TryReceive(ref byte[] buffer, out int length, out double receivedS)
        {
            receivedS = Clock.NowS;
            length = 0;
            IsRestarted = false;
            if (!_ready && !IsEnded) ReadNext(receivedS);
            if (!_ready || receivedS < _dueS) return false;
            _ready = false;
            length = _datagram.Length;
            if (buffer.Length < length) buffer = new byte[length];
            Buffer.BlockCopy(_datagram.Bytes, 0, buffer, 0, length);
            return true;
        }

        public void Dispose()
        {
            _lines.Dispose();
        }

        TextReader Open()
        {
            try
            {
                return _open();
            }
            catch (Exception error) when (error is IOException || error is UnauthorizedAccessException)
            {
                throw new InputException("cannot read " + _name + " (" + error.Message + ")");
            }
        }

        void ReadNext(double nowS)
        {
            while (!_ready && !IsEnded)
            {
                var text = _lines.ReadLine();
                _number++;
                if (text == null) EndRound();
                else if (text.Trim().Length > 0) ReadLine(text, nowS);
                if (IsRestarted) return;
            }
        }

        void EndRound()
        {
            var empty = _firstUs < 0;
            _firstUs = -1;
            _number = 0;
            _lines.Dispose();
            IsEnded = !_loop || empty;
            if (IsEnded) return;
            _lines = Open();
            IsRestarted = true;
        }

        void ReadLine(string text, double nowS)
        {
            try
            {
                var line = new JsonFields(JsonReader.Read(text));
                if (line.Has("time_us")) SetDue(RecordedLine.TimeUs(line), nowS);
                _ready = RecordedLine.Write(line, Math.Max(0, _firstUs), _datagram);
            }
            catch (InputException error)
            {
                Problem = _name + ", line " + _number + ", is no frame: " + error.Message;
                IsEnded = true;
            }
        }

        void SetDue(long timeUs, double nowS)
        {
            if (_firstUs < 0)
            {
                _firstUs = timeUs;
                _startedS = nowS;
            }
            _dueS = _startedS + (timeUs - _firstUs) / 1e6;
        }
    }
}
