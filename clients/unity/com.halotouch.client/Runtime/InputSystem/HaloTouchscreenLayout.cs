using System.Text;

namespace HaloTouch
{
    // The Input System's layout of the device: a touchscreen, and for each slot the height and the
    // force as own controls. They lie behind the state of the touches.
    static class HaloTouchscreenLayout
    {
        public const string Name = "HaloTouchscreen";
        public const int Slots = 10;
        public const string Hover = "hover";
        public const string Force = "force";

        public static string Json()
        {
            var json = new StringBuilder();
            json.Append("{\"name\": \"" + Name + "\", \"extend\": \"Touchscreen\", ");
            json.Append("\"displayName\": \"Halo Touchscreen\", \"controls\": [");
            for (var slot = 0; slot < Slots; slot++)
            {
                json.Append(slot > 0 ? ", " : "").Append(Control(Hover + slot, "Hover " + slot + " (mm)"));
                json.Append(", ").Append(Control(Force + slot, "Force " + slot + " (g)"));
            }
            return json.Append("]}").ToString();
        }

        // Without an offset the Input System puts a control after those that have one.
        static string Control(string name, string displayName) =>
            "{\"name\": \"" + name + "\", \"displayName\": \"" + displayName +
            "\", \"layout\": \"Axis\", \"format\": \"FLT\", \"noisy\": true}";
    }
}
