using System.Collections.Generic;

namespace HaloTouch.Internal
{
    // A line of a recorded stream as the datagram that it was, so that a recording goes through the
    // same assembler as a live stream. It reads the lines of `halo replay --jsonl` and of
    // `halo-monitor --json`.
    static class RecordedLine
    {
        const int Modulus = 1 << 24;
        const long LatestUs = 2147483647L * 1000000L;

        // False for a line that is no message, such as `lost`. InputException for a bad line.
        public static bool Write(JsonFields line, long firstUs, OscWriter into)
        {
            into.Start().Bundle();
            var kind = line.TextOr("kind", "frame");
            if (kind == "frame") WriteFrame(line, firstUs, into);
            else if (kind == "scene") WriteScene(line, into);
            else if (kind == "homography") WriteHomography(line, into);
            else if (kind == "pose") WritePose(line, into);
            else if (kind == "health") WriteHealth(line, into);
            else return false;
            return into.Length <= DatagramReader.MaxBytes ? true : throw new InputException("it is too long");
        }

        public static long TimeUs(JsonFields line) => line.Long("time_us", 0, LatestUs);

        static string Address(JsonFields line, string kind) =>
            "/halo/1/" + line.Text("surface") + "/" + kind;

        static OscWriter Sender(JsonFields line, OscWriter into) =>
            into.Text(line.Text("node")).Text(line.Text("session"));

        static void WriteFrame(JsonFields line, long firstUs, OscWriter into)
        {
            var timeUs = TimeUs(line);
            var sinceMs = (int)(((timeUs - firstUs) / 1000) & (Modulus - 1));
            var pointers = line.List("pointers");
            into.Element(Address(line, "frame"), ",ssiiiii");
            Sender(line, into).Int(line.Int("frame"));
            into.Int((int)(timeUs / 1000000)).Int((int)(timeUs % 1000000)).Int(pointers.Count);
            into.Int(line.IntOr("session_ms", sinceMs)).EndElement();
            foreach (var each in line.List("events")) WriteContact(line, new JsonFields(each), into);
            foreach (var each in pointers) WritePointer(line, new JsonFields(each), into);
            into.Element(Address(line, "alive"), "," + new string('i', pointers.Count));
            foreach (var each in pointers) into.Int(new JsonFields(each).Int("id"));
            into.EndElement();
        }

        static void WriteContact(JsonFields line, JsonFields contact, OscWriter into)
        {
            var isUp = contact.Text("kind") == "up";
            into.Element(Address(line, isUp ? "up" : "down"), isUp ? ",iifffi" : ",iiffffi");
            into.Int(contact.Int("id")).Int(contact.Int("slot"));
            Floats(contact, into, "u", "v");
            if (!isUp) Floats(contact, into, "strike_mm_s");
            Floats(contact, into, "ago_ms");
            into.Int(contact.Int("contacts")).EndElement();
        }

        static void WritePointer(JsonFields line, JsonFields pointer, OscWriter into)
        {
            into.Element(Address(line, "pointer"), ",iiiiifffffffffif");
            into.Int(pointer.Int("id")).Int(pointer.Int("slot")).Int(pointer.Word<HaloHand>("hand"));
            into.Int(pointer.Word<HaloFinger>("finger")).Int(pointer.Word<HaloState>("state"));
            Floats(
                pointer, into, "u", "v", "x_mm", "y_mm", "hover_mm", "pressure", "vx_mm_s", "vy_mm_s",
                "confidence");
            into.Int(pointer.Int("contacts"));
            Floats(pointer, into, "force_g");
            into.EndElement();
        }

        static void WriteScene(JsonFields line, OscWriter into)
        {
            into.Element(Address(line, "scene"), ",sssffiiifiiiss");
            Sender(line, into).Text(line.Text("version"));
            Floats(line, into, "width_mm", "height_mm");
            into.Int(line.Word<HaloCalibration>("calibration")).Int(line.Int("revision"));
            into.Int(line.Word<HaloSource>("source"));
            Floats(line, into, "rate_hz");
            into.Int(line.Int("control_port")).Int(line.Int("collision"));
            into.Int(line.Int("calibrated_s")).Text(line.Text("service_version"));
            into.Text(line.Text("zenoh_version")).EndElement();
        }

        static void WriteHomography(JsonFields line, OscWriter into)
        {
            into.Element(Address(line, "homography"), ",ssiiifffffffff");
            Sender(line, into).Int(line.Int("revision"));
            into.Int(line.Int("width_px")).Int(line.Int("height_px"));
            Numbers(line.List("projector_from_surface"), 9, into);
            into.EndElement();
        }

        static void WritePose(JsonFields line, OscWriter into)
        {
            into.Element(Address(line, "pose"), ",ssiffffffffffffffffffffffffi");
            Sender(line, into).Int(line.Int("revision"));
            Numbers(line.List("camera_from_surface"), 12, into);
            Numbers(line.List("anchor_from_surface"), 12, into);
            into.Int(line.Int("anchored")).EndElement();
        }

        static void WriteHealth(JsonFields line, OscWriter into)
        {
            into.Element(Address(line, "health"), ",ssffiiiififiiiiifiiiff");
            Sender(line, into);
            Floats(line, into, "fps", "latency_ms");
            into.Int(line.Int("drops")).Int(line.Int("bad_frames"));
            into.Int(line.Word<HaloTracker>("tracker")).Int(line.Word<HaloCamera>("camera"));
            Floats(line, into, "tracker_ms");
            into.Int(line.Int("clock_jumps"));
            Floats(line, into, "clock_error_ms");
            into.Int(line.Word<HaloProfileFit>("profile_fit")).Int(line.Int("zenoh_missing"));
            into.Int(line.Int("write_errors")).Int(line.Int("memory_mb"));
            into.Int(line.Word<HaloLoad>("load"));
            Floats(line, into, "looks_hz");
            into.Int(line.Int("time_s")).Int(line.Int("time_frac_us")).Int(line.Int("nodes"));
            Floats(line, into, "clock_offset_ms", "clock_deviation_ms");
            into.EndElement();
        }

        static void Floats(JsonFields fields, OscWriter into, params string[] names)
        {
            foreach (var name in names) into.Float(fields.Float(name));
        }

        static void Numbers(List<object> numbers, int count, OscWriter into)
        {
            if (numbers.Count != count) throw new InputException("a matrix has " + count + " numbers");
            foreach (var each in numbers)
                into.Float(each is double number ? (float)number : throw new InputException("a number is expected"));
        }
    }
}
