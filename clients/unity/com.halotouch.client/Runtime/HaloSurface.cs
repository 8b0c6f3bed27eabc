using HaloTouch.Internal;
using UnityEngine;

namespace HaloTouch
{
    /// <summary>
    /// The touch surface in the scene: x to the right, y up from the surface, z to the far edge, in
    /// metres. The position is the middle of the surface. With a marker (AR) it places itself.
    /// </summary>
    [AddComponentMenu("Halo Touch/Halo Surface")]
    [DefaultExecutionOrder(-490)]
    public sealed class HaloSurface : MonoBehaviour
    {
        const float FingerRadiusM = 0.006f;

        [SerializeField]
        HaloReceiver receiver = null;

        [SerializeField]
        [Tooltip("AR: the printed marker in the scene, x to its right, y up from the paper, z to its top, as " +
            "AR Foundation's tracked images. Empty: this transform stays where you put it")]
        Transform marker = null;

        [SerializeField]
        [Tooltip("Size in mm until the service reports it")]
        Vector2 sizeMm = new Vector2(300, 200);

        /// <summary>The surface that was enabled last, or null.</summary>
        public static HaloSurface Active { get; private set; }

        /// <summary>The receiver of its fingers.</summary>
        public HaloReceiver Receiver
        {
            get => receiver;
            set => receiver = value;
        }

        /// <summary>AR: the printed marker in the scene, or null.</summary>
        public Transform Marker
        {
            get => marker;
            set => marker = value;
        }

        /// <summary>Whether a marker has placed the surface.</summary>
        public bool IsAnchored { get; private set; }

        /// <summary>Width and height in mm.</summary>
        public Vector2 SizeMm
        {
            get
            {
                if (receiver != null && receiver.TryGetScene(out var scene))
                    return new Vector2(scene.WidthMm, scene.HeightMm);
                return sizeMm;
            }
        }

        /// <summary>World position of a fingertip, in metres.</summary>
        public Vector3 ToWorld(HaloPointer pointer) => ToWorld(pointer.XMm, pointer.YMm, pointer.HoverMm);

        /// <summary>World position of a touch, in metres.</summary>
        public Vector3 ToWorld(HaloContact contact)
        {
            var size = SizeMm;
            return ToWorld(contact.U * size.x, contact.V * size.y, 0);
        }

        /// <summary>
        /// World position in metres of a place in mm from the far left corner, to the right, towards
        /// the user and above the surface.
        /// </summary>
        public Vector3 ToWorld(float xMm, float yMm, float hoverMm)
        {
            var size = SizeMm;
            var local = SurfaceSpace.ToLocal(xMm, yMm, hoverMm, size.x, size.y);
            return transform.TransformPoint(ToVector(local));
        }

        /// <summary>Velocity of a fingertip along the surface, in m/s in the world.</summary>
        public Vector3 VelocityToWorld(HaloPointer pointer) =>
            transform.TransformVector(new Vector3(pointer.VxMmS, 0, -pointer.VyMmS) / 1000);

        /// <summary>
        /// Screen pixels of a place on the surface, (0, 0) bottom left. With a projector, the game is
        /// its full-screen picture; without one, the surface is the whole screen.
        /// </summary>
        public Vector2 ToScreen(float u, float v)
        {
            if (receiver == null || !receiver.TryGetHomography(out var found))
                return new Vector2(u * Screen.width, (1 - v) * Screen.height);
            var size = SizeMm;
            var h = found.ProjectorFromSurface;
            float x = u * size.x, y = v * size.y;
            var w = h.M20 * x + h.M21 * y + h.M22;
            var pixelX = (h.M00 * x + h.M01 * y + h.M02) / w;
            var pixelY = (h.M10 * x + h.M11 * y + h.M12) / w;
            return new Vector2(
                pixelX / found.WidthPx * Screen.width, (1 - pixelY / found.HeightPx) * Screen.height);
        }

        void OnEnable()
        {
            Active = this;
        }

        void OnDisable()
        {
            if (Active == this) Active = null;
        }

        void Update()
        {
            if (marker == null || receiver == null) return;
            if (!receiver.TryGetPose(out var pose) || !pose.IsAnchored) return;
            var size = SizeMm;
            var placed = SurfaceSpace.InMarker(pose.AnchorFromSurface, size.x, size.y);
            var rotation = Quaternion.LookRotation(ToVector(placed.Forward), ToVector(placed.Up));
            // Without the marker's scale: content below a tracked image is often scaled to its size.
            transform.SetPositionAndRotation(
                marker.position + marker.rotation * ToVector(placed.Position), marker.rotation * rotation);
            IsAnchored = true;
        }

        static Vector3 ToVector(Metres metres) => new Vector3(metres.X, metres.Y, metres.Z);

        void OnDrawGizmos()
        {
            var size = SizeMm;
            Gizmos.color = Color.cyan;
            Vector3 farLeft = ToWorld(0, 0, 0), farRight = ToWorld(size.x, 0, 0);
            Vector3 nearLeft = ToWorld(0, size.y, 0), nearRight = ToWorld(size.x, size.y, 0);
            Gizmos.DrawLine(farLeft, farRight);
            Gizmos.DrawLine(farRight, nearRight);
            Gizmos.DrawLine(nearRight, nearLeft);
            Gizmos.DrawLine(nearLeft, farLeft);
            if (receiver == null) return;
            foreach (var pointer in receiver.Frame.Pointers) DrawFinger(pointer);
        }

        void DrawFinger(HaloPointer pointer)
        {
            var tip = ToWorld(pointer);
            Gizmos.color = pointer.IsTouching ? Color.red : Color.yellow;
            Gizmos.DrawLine(ToWorld(pointer.XMm, pointer.YMm, 0), tip);
            Gizmos.DrawWireSphere(tip, FingerRadiusM * (1 + pointer.Pressure));
        }
    }
}
