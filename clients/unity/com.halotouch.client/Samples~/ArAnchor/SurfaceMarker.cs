using HaloTouch;
using UnityEngine;

/// <summary>
/// For the prefab of AR Foundation's tracked images: gives the printed marker to the Halo Surface of the
/// scene, which then lies where the table is.
/// </summary>
public sealed class SurfaceMarker : MonoBehaviour
{
    void Update()
    {
        if (HaloSurface.Active != null) HaloSurface.Active.Marker = transform;
    }
}
