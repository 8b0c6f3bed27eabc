namespace HaloTouch.Internal
{
    enum MessageKind { Unknown, Frame, Pointer, Alive, Down, Up, Scene, Homography, Pose, Health }

    // The arguments of one message, with the checks that a client relies on. Arguments after the last
    // one here are of a later minor version and are not read.
    sealed class MessageReader
    {
        const int Modulus = 1 << 24;
        const int MaxPointers = 64;
        const int MaxContacts = 256;

        readonly NameCache _names;

        public MessageReader(NameCache names)
        {
            _names = names;
        }

        public static MessageKind KindOf(byte[] bytes, int start, int stop)
        {
            if (Ascii.Equal(bytes, start, stop, "pointer")) return MessageKind.Pointer;
            if (Ascii.Equal(bytes, start, stop, "frame")) return MessageKind.Frame;
            if (Ascii.Equal(bytes, start, stop, "alive")) return MessageKind.Alive;
            if (Ascii.Equal(bytes, start, stop, "down")) return MessageKind.Down;
            if (Ascii.Equal(bytes, start, stop, "up")) return MessageKind.Up;
            if (Ascii.Equal(bytes, start, stop, "scene")) return MessageKind.Scene;
            if (Ascii.Equal(bytes, start, stop, "homography")) return MessageKind.Homography;
            if (Ascii.Equal(bytes, start, stop, "pose")) return MessageKind.Pose;
            if (Ascii.Equal(bytes, start, stop, "health")) return MessageKind.Health;
            return MessageKind.Unknown;
        }

        public void Read(ref OscReader reader, MessageKind kind, string surface, Datagram into)
        {
            if (kind == MessageKind.Frame) ReadFrame(ref reader, surface, into);
            else if (kind == MessageKind.Scene) ReadScene(ref reader, surface, into);
            else if (kind == MessageKind.Homography) ReadHomography(ref reader, surface, into);
            else if (kind == MessageKind.Pose) ReadPose(ref reader, surface, into);
            else if (kind == MessageKind.Health) ReadHealth(ref reader, surface, into);
            else
            {
                var part = into.FindOpen(surface);
                if (part == null) reader.Fail("a message comes before its frame's header");
                else if (kind == MessageKind.Pointer) ReadPointer(ref reader, part);
                else if (kind == MessageKind.Alive) ReadAlive(ref reader, part, into);
                else ReadContact(ref reader, kind == MessageKind.Up, part);
            }
        }

        static void RequireEnd(ref OscReader reader, int further) =>
            reader.Require(further > 0 || reader.Left == 0, "a message has bytes too many");

        static void RequireTime(ref OscReader reader, int timeS, int timeFracUs)
        {
            reader.Require(timeS >= 0, "time_s is negative");
            reader.Require(
                timeFracUs >= 0 && timeFracUs < 1000000, "time_frac_us is out of range");
        }

        void ReadFrame(ref OscReader reader, string surface, Datagram into)
        {
            var further = reader.Tags(",ssiiiii");
            var header = new Header(
                reader.Name(_names, NameKind.Node), reader.Name(_names, NameKind.Session),
                reader.Int(), reader.Int(), reader.Int(), reader.Int(), reader.Int());
            RequireEnd(ref reader, further);
            reader.Require(header.Frame >= 0 && header.Frame < Modulus, "frame is out of range");
            RequireTime(ref reader, header.TimeS, header.TimeFracUs);
            reader.Require(
                header.SessionMs >= 0 && header.SessionMs < Modulus, "session_ms is out of range");
            reader.Require(header.Count >= 0 && header.Count <= MaxPointers, "count is out of range");
            reader.Require(
                into.FindOpen(surface) == null, "a frame starts before the last one has ended");
            if (reader.Error == null) into.Open(surface, in header);
        }

        static void ReadPointer(ref OscReader reader, Part part)
        {
            var further = reader.Tags(",iiiiifffffffffif");
            var pointer = new HaloPointer(
                reader.Int(), reader.Int(), (HaloHand)reader.Int(), (HaloFinger)reader.Int(),
                (HaloState)reader.Int(), reader.Float(), reader.Float(), reader.Float(),
                reader.Float(), reader.Float(), reader.Float(), reader.Float(), reader.Float(),
                reader.Float(), reader.Int(), reader.Float());
            RequireEnd(ref reader, further);
            RequireCounted(ref reader, pointer.Id, pointer.Slot, pointer.Contacts);
            reader.Require(part.FindPointer(pointer.Id) < 0, "a pointer comes twice");
            reader.Require(part.Pointers.Count < MaxPointers, "a frame has too many pointers");
            if (reader.Error == null) part.Pointers.Add(in pointer);
        }

        static void RequireCounted(ref OscReader reader, int id, int slot, int contacts) =>
            reader.Require(
                id >= 0 && slot >= 0 && contacts >= 0, "id, slot and contacts must not be negative");

        static void ReadContact(ref OscReader reader, bool isUp, Part part)
        {
            var further = reader.Tags(isUp ? ",iifffi" : ",iiffffi");
            var contact = new HaloContact(
                isUp, reader.Int(), reader.Int(), reader.Float(), reader.Float(),
                isUp ? 0 : reader.Float(), reader.Float(), reader.Int());
            RequireEnd(ref reader, further);
            RequireCounted(ref reader, contact.Id, contact.Slot, contact.Contacts);
            reader.Require(part.Contacts.Count < MaxContacts, "a frame has too many events");
            if (reader.Error == null) part.Contacts.Add(in contact);
        }

        static void ReadAlive(ref OscReader reader, Part part, Datagram into)
        {
            var count = part.Header.Count;
            var further = reader.Tags(Tags[count]);
            reader.Require(further == 0, "count is not the number of ids");
            for (var i = 0; i < count; i++)
            {
                var id = reader.Int();
                reader.Require(!part.IsAlive(id), "the alive list has an id twice");
                if (reader.Error == null) part.Ids.Add(in id);
            }
            reader.Require(reader.Left == 0, "alive has bytes too many");
            for (var i = 0; i < part.Pointers.Count; i++)
                reader.Require(part.IsAlive(part.Pointers.Items[i].Id), "a pointer is not alive");
            if (reader.Error == null) into.Close(part);
        }

        static readonly string[] Tags = AliveTags();

        static string[] AliveTags()
        {
            var tags = new string[MaxPointers + 1];
            for (var i = 0; i <= MaxPointers; i++) tags[i] = "," + new string('i', i);
            return tags;
        }

        void ReadScene(ref OscReader reader, string surface, Datagram into)
        {
            var further = reader.Tags(",sssffiiifiiiss");
            var node = reader.Name(_names, NameKind.Node);
            var session = reader.Name(_names, NameKind.Session);
            var version = reader.Name(_names, NameKind.Version);
            float widthMm = reader.Float(), heightMm = reader.Float();
            var calibration = (HaloCalibration)reader.Int();
            var revision = reader.Int();
            var source = (HaloSource)reader.Int();
            var rateHz = reader.Float();
            var port = reader.Int();
            var collision = reader.Int();
            var calibratedS = reader.Int();
            var serviceVersion = reader.Name(_names, NameKind.Program);
            var zenohVersion = reader.Name(_names, NameKind.Program);
            RequireEnd(ref reader, further);
            reader.Require(widthMm > 0 && heightMm > 0, "the size of a surface must be positive");
            reader.Require(port >= 0 && port < 65536, "control_port is out of range");
            reader.Require(collision == 0 || collision == 1, "collision must be 0 or 1");
            reader.Require(calibratedS >= 0, "calibrated_s must be 0 or more");
            if (reader.Error == null)
                into.AddReport(ItemKind.Scene, surface).Scene = new HaloScene(
                    node, session, version, widthMm, heightMm, calibration, revision, source, rateHz,
                    port, collision == 1, calibratedS, serviceVersion, zenohVersion);
        }

        void ReadHomography(ref OscReader reader, string surface, Datagram into)
        {
            var further = reader.Tags(",ssiiifffffffff");
            var found = new HaloHomography(
                reader.Name(_names, NameKind.Node), reader.Name(_names, NameKind.Session),
                reader.Int(), reader.Int(), reader.Int(), ReadMatrix(ref reader));
            RequireEnd(ref reader, further);
            reader.Require(
                found.WidthPx > 0 && found.HeightPx > 0, "the size of an image must be positive");
            if (reader.Error == null) into.AddReport(ItemKind.Homography, surface).Homography = found;
        }

        void ReadPose(ref OscReader reader, string surface, Datagram into)
        {
            var further = reader.Tags(",ssiffffffffffffffffffffffffi");
            var node = reader.Name(_names, NameKind.Node);
            var session = reader.Name(_names, NameKind.Session);
            var revision = reader.Int();
            HaloMatrix34 camera = ReadRigid(ref reader), anchor = ReadRigid(ref reader);
            var anchored = reader.Int();
            RequireEnd(ref reader, further);
            reader.Require(anchored == 0 || anchored == 1, "anchored must be 0 or 1");
            if (reader.Error == null)
                into.AddReport(ItemKind.Pose, surface).Pose = new HaloPose(
                    node, session, revision, camera, anchor, anchored == 1);
        }

        static HaloMatrix33 ReadMatrix(ref OscReader reader) =>
            new HaloMatrix33(
                reader.Float(), reader.Float(), reader.Float(), reader.Float(), reader.Float(),
                reader.Float(), reader.Float(), reader.Float(), reader.Float());

        static HaloMatrix34 ReadRigid(ref OscReader reader)
        {
            float a = reader.Float(), b = reader.Float(), c = reader.Float(), x = reader.Float();
            float d = reader.Float(), e = reader.Float(), f = reader.Float(), y = reader.Float();
            float g = reader.Float(), h = reader.Float(), i = reader.Float(), z = reader.Float();
            return new HaloMatrix34(new HaloMatrix33(a, b, c, d, e, f, g, h, i), x, y, z);
        }

        void ReadHealth(ref OscReader reader, string surface, Datagram into)
        {
            var further = reader.Tags(",ssffiiiififiiiiifiiiff");
            var found = new HaloHealth(
                reader.Name(_names, NameKind.Node), reader.Name(_names, NameKind.Session),
                reader.Float(), reader.Float(), reader.Int(), reader.Int(),
                (HaloTracker)reader.Int(), (HaloCamera)reader.Int(), reader.Float(), reader.Int(),
                reader.Float(), (HaloProfileFit)reader.Int(), reader.Int(), reader.Int(), reader.Int(),
                (HaloLoad)reader.Int(), reader.Float(), reader.Int(), reader.Int(), reader.Int(),
                reader.Float(), reader.Float());
            RequireEnd(ref reader, further);
            RequireTime(ref reader, found.TimeS, found.TimeFracUs);
            if (reader.Error == null) into.AddReport(ItemKind.Health, surface).Health = found;
        }
    }
}
