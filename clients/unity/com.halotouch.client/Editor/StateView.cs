using UnityEditor;

namespace HaloTouch.Editor
{
    // Lines of text about a frame.
    static class StateView
    {
        public static void Show(HaloReceiver receiver)
        {
            EditorGUILayout.LabelField(receiver.Status);
            if (receiver.TryGetScene(out var scene))
                EditorGUILayout.LabelField(
                    scene.WidthMm.ToString("0") + " x " + scene.HeightMm.ToString("0") + " mm, " +
                    scene.Source + ", calibration " + scene.Calibration);
            if (receiver.TryGetHealth(out var health))
                EditorGUILayout.LabelField(
                    health.Fps.ToString("0") + " frames/s, " + health.LatencyMs.ToString("0.0") + " ms, camera " +
                    health.Camera + ", tracker " + health.Tracker);
            ShowFingers(receiver.Frame);
            EditorGUILayout.LabelField("lost " + receiver.MissedFrames + ", bad " + receiver.BadDatagrams);
        }

        public static string Name(HaloFrame frame) =>
            frame.Node.Length == 0 ? "no frames yet" : frame.Node + "/" + frame.Surface + ", frame " + frame.Number;

        public static void ShowFingers(HaloFrame frame)
        {
            foreach (var pointer in frame.Pointers)
                EditorGUILayout.LabelField(
                    pointer.Slot + ": " + pointer.Hand + " " + pointer.Finger + " at " +
                    pointer.XMm.ToString("0") + ", " + pointer.YMm.ToString("0") + " mm",
                    pointer.IsTouching
                        ? "touch, pressure " + pointer.Pressure.ToString("0.00")
                        : pointer.HoverMm.ToString("0") + " mm above");
        }
    }
}
