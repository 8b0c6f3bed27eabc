// The JSON view of protocol/SPEC.md, so that lines can be compared with those of the Python client.
using System.Globalization;
using System.Text;
using HaloTouch;
using HaloTouch.Internal;

static class View
{
    public static string Event(SessionEvent found)
    {
        if (found.Kind == EventKind.Frame) return Frame(found.Frame);
        if (found.Kind == EventKind.Report) return Report(found);
        var place = Text("surface", found.Surface) + Text("node", found.Node);
        if (found.Kind == EventKind.Lost) return Object(Text("kind", "lost") + place + Text("session", found.Session));
        return Object(
            Text("kind", "collision") + place +
            Field("sessions", "[\"" + found.Session + "\", \"" + found.NewerSession + "\"]"));
    }

    public static string Frame(HaloFrame frame) =>
        Object(
            Text("kind", "frame") + Field("time_us", frame.TimeUs) + Text("surface", frame.Surface) +
            Text("node", frame.Node) + Text("session", frame.Session) + Field("frame", frame.Number) +
            Field("session_ms", frame.SessionMs) + Field("pointers", Pointers(frame.PointerItems)) +
            Field("events", Contacts(frame.ContactItems)) + Field("missed", frame.Missed) +
            Field("complete", frame.IsComplete ? "true" : "false"));

    public static string Item(Item item)
    {
        if (item.Kind == ItemKind.Part) return Part(item.Part);
        var events = new EventQueue();
        events.AddReport(item);
        return Report(events[0]);
    }

    static string Part(Part part)
    {
        var header = part.Header;
        var ids = new StringBuilder();
        for (var i = 0; i < part.Ids.Count; i++) ids.Append(i > 0 ? ", " : "").Append(part.Ids.Items[i]);
        return Object(
            Text("kind", "part") + Text("surface", part.Surface) + Text("node", header.Node) +
            Text("session", header.Session) + Field("frame", header.Frame) + Field("time_s", header.TimeS) +
            Field("time_frac_us", header.TimeFracUs) + Field("count", header.Count) +
            Field("session_ms", header.SessionMs) + Field("ids", "[" + ids + "]") +
            Field("pointers", Pointers(part.Pointers)) + Field("events", Contacts(part.Contacts)));
    }

    static string Report(SessionEvent found)
    {
        var head = Text("surface", found.Surface) + Text("node", found.Node) + Text("session", found.Session);
        if (found.ReportKind == ItemKind.Scene) return Object(Text("kind", "scene") + head + Scene(found.Scene));
        if (found.ReportKind == ItemKind.Homography) return Object(Text("kind", "homography") + head + Homography(found.Homography));
        if (found.ReportKind == ItemKind.Pose) return Object(Text("kind", "pose") + head + Pose(found.Pose));
        return Object(Text("kind", "health") + head + Health(found.Health));
    }

    static string Scene(HaloScene scene) =>
        Text("version", scene.Version) + Field("width_mm", scene.WidthMm) + Field("height_mm", scene.HeightMm) +
        Word("calibration", scene.Calibration) + Field("revision", scene.Revision) + Word("source", scene.Source) +
        Field("rate_hz", scene.RateHz) + Field("control_port", scene.ControlPort) +
        Field("collision", scene.Collision ? 1 : 0) + Field("calibrated_s", scene.CalibratedS) +
        Text("service_version", scene.ServiceVersion) + Text("zenoh_version", scene.ZenohVersion);

    static string Homography(HaloHomography found) =>
        Field("revision", found.Revision) + Field("width_px", found.WidthPx) + Field("height_px", found.HeightPx) +
        Field("projector_from_surface", "[" + Rows(found.ProjectorFromSurface) + "]");

    static string Pose(HaloPose pose) =>
        Field("revision", pose.Revision) + Field("camera_from_surface", Rigid(pose.CameraFromSurface)) +
        Field("anchor_from_surface", Rigid(pose.AnchorFromSurface)) + Field("anchored", pose.IsAnchored ? 1 : 0);

    static string Rows(HaloMatrix33 m) =>
        string.Join(", ", new[] { Number(m.M00), Number(m.M01), Number(m.M02), Number(m.M10), Number(m.M11), Number(m.M12), Number(m.M20), Number(m.M21), Number(m.M22) });

    static string Rigid(HaloMatrix34 m)
    {
        var r = m.Rotation;
        return "[" + string.Join(", ", new[] {
            Number(r.M00), Number(r.M01), Number(r.M02), Number(m.XMm),
            Number(r.M10), Number(r.M11), Number(r.M12), Number(m.YMm),
            Number(r.M20), Number(r.M21), Number(r.M22), Number(m.ZMm) }) + "]";
    }

    static string Health(HaloHealth health) =>
        Field("fps", health.Fps) + Field("latency_ms", health.LatencyMs) + Field("drops", health.Drops) +
        Field("bad_frames", health.BadFrames) + Word("tracker", health.Tracker) + Word("camera", health.Camera) +
        Field("tracker_ms", health.TrackerMs) + Field("clock_jumps", health.ClockJumps) +
        Field("clock_error_ms", health.ClockErrorMs) + Word("profile_fit", health.ProfileFit) +
        Field("zenoh_missing", health.ZenohMissing) + Field("write_errors", health.WriteErrors) +
        Field("memory_mb", health.MemoryMb) + Word("load", health.Load) + Field("looks_hz", health.LooksHz) +
        Field("time_s", health.TimeS) + Field("time_frac_us", health.TimeFracUs) +
        Field("nodes", health.Nodes) + Field("clock_offset_ms", health.ClockOffsetMs) +
        Field("clock_deviation_ms", health.ClockDeviationMs);

    static string Pointers(Growing<HaloPointer> pointers)
    {
        var text = new StringBuilder("[");
        for (var i = 0; i < pointers.Count; i++) text.Append(i > 0 ? ", " : "").Append(Pointer(pointers.Items[i]));
        return text.Append("]").ToString();
    }

    static string Pointer(HaloPointer p) =>
        Object(
            Field("id", p.Id) + Field("slot", p.Slot) + Word("hand", p.Hand) + Word("finger", p.Finger) +
            Word("state", p.State) + Field("u", p.U) + Field("v", p.V) + Field("x_mm", p.XMm) +
            Field("y_mm", p.YMm) + Field("hover_mm", p.HoverMm) + Field("pressure", p.Pressure) +
            Field("vx_mm_s", p.VxMmS) + Field("vy_mm_s", p.VyMmS) + Field("confidence", p.Confidence) +
            Field("contacts", p.Contacts) + Field("force_g", p.ForceG));

    static string Contacts(Growing<HaloContact> contacts)
    {
        var text = new StringBuilder("[");
        for (var i = 0; i < contacts.Count; i++) text.Append(i > 0 ? ", " : "").Append(Contact(contacts.Items[i]));
        return text.Append("]").ToString();
    }

    static string Contact(HaloContact c) =>
        Object(
            Text("kind", c.IsUp ? "up" : "down") + Field("id", c.Id) + Field("slot", c.Slot) + Field("u", c.U) +
            Field("v", c.V) + (c.IsUp ? "" : Field("strike_mm_s", c.StrikeMmS)) + Field("ago_ms", c.AgoMs) +
            Field("contacts", c.Contacts));

    static string Object(string fields) => "{" + fields.Substring(2) + "}";

    static string Field(string name, string json) => ", \"" + name + "\": " + json;

    static string Field(string name, long value) => Field(name, value.ToString(CultureInfo.InvariantCulture));

    static string Field(string name, float value) => Field(name, Number(value));

    public static string Text(string name, string value) => Field(name, "\"" + value + "\"");

    // An unknown number stays a number.
    static string Word<T>(string name, T value) where T : struct
    {
        var word = value.ToString().ToLowerInvariant();
        return Field(name, char.IsLetter(word[0]) ? "\"" + word + "\"" : word);
    }

    // The digits of a float32 as a double, as Python prints them.
    public static string Number(double value) => value.ToString("R", CultureInfo.InvariantCulture);
}
