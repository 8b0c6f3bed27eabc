using System.Collections.Generic;
using HaloTouch;
using UnityEngine;

/// <summary>
/// Shows a sphere at each fingertip, for headsets and phones. Add it to the object of a Halo Surface.
/// </summary>
[RequireComponent(typeof(HaloSurface))]
public sealed class FingerSpheres : MonoBehaviour
{
    const int Slots = 10;
    const float DiameterM = 0.01f;

    readonly List<GameObject> _spheres = new List<GameObject>();
    HaloSurface _surface;

    void Start()
    {
        _surface = GetComponent<HaloSurface>();
        for (var i = 0; i < Slots; i++)
        {
            var sphere = GameObject.CreatePrimitive(PrimitiveType.Sphere);
            sphere.transform.SetParent(transform);
            sphere.SetActive(false);
            _spheres.Add(sphere);
        }
    }

    void Update()
    {
        if (_surface.Receiver == null) return;
        foreach (var sphere in _spheres) sphere.SetActive(false);
        foreach (var pointer in _surface.Receiver.Frame.Pointers)
        {
            if (pointer.Slot >= Slots) continue;
            var sphere = _spheres[pointer.Slot];
            sphere.SetActive(true);
            sphere.transform.position = _surface.ToWorld(pointer);
            sphere.transform.localScale = DiameterM * (1 + pointer.Pressure) * Vector3.one;
            sphere.GetComponent<Renderer>().material.color = pointer.IsTouching ? Color.red : Color.yellow;
        }
    }
}
