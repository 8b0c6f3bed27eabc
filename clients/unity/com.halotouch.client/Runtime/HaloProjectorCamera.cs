using HaloTouch.Internal;
using UnityEngine;

namespace HaloTouch
{
    /// <summary>
    /// Makes the camera's picture fall on the table in the right place: show it full screen on the
    /// projector. Each point of the surface is drawn on the pixel that lights it, by the service's
    /// homography. What is above the surface is drawn straight down onto it.
    /// </summary>
    [AddComponentMenu("Halo Touch/Halo Projector Camera")]
    [RequireComponent(typeof(Camera))]
    public sealed class HaloProjectorCamera : MonoBehaviour
    {
        [SerializeField]
        HaloSurface surface = null;

        [SerializeField]
        [Tooltip("Height of the camera above the surface in metres: what is lower than that is drawn")]
        float heightM = 2;

        readonly float[] _rows = new float[16];
        Camera _camera;

        /// <summary>The surface onto which it projects.</summary>
        public HaloSurface Surface
        {
            get => surface;
            set => surface = value;
        }

        /// <summary>Whether a homography is in use; else the camera shows the surface from above.</summary>
        public bool IsProjecting { get; private set; }

        void OnEnable()
        {
            _camera = GetComponent<Camera>();
        }

        void OnDisable()
        {
            if (_camera != null) _camera.ResetProjectionMatrix();
            IsProjecting = false;
        }

        void LateUpdate()
        {
            if (surface == null) return;
            var up = surface.transform.up;
            transform.SetPositionAndRotation(
                surface.transform.position + heightM * up,
                Quaternion.LookRotation(-up, surface.transform.forward));
            if (!TryFill())
            {
                if (!IsProjecting) ShowFromAbove();
                return;
            }
            var matrix = new Matrix4x4();
            for (var i = 0; i < 16; i++) matrix[i / 4, i % 4] = _rows[i];
            _camera.orthographic = false;
            _camera.projectionMatrix = matrix;
            IsProjecting = true;
        }

        bool TryFill()
        {
            if (surface.Receiver == null || !surface.Receiver.TryGetHomography(out var found)) return false;
            var size = surface.SizeMm;
            return ProjectorMatrix.Fill(in found, size.x, size.y, heightM, _rows);
        }

        // Until there is a homography: the whole surface, as large as it fits.
        void ShowFromAbove()
        {
            var size = surface.SizeMm / 1000;
            _camera.orthographic = true;
            _camera.orthographicSize = Mathf.Max(size.y, size.x / _camera.aspect) / 2;
        }
    }
}
