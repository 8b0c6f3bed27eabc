// Runs the package's components on the stand-ins of ../stubs: what they do with a recording, as lines of JSON.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Reflection;
using System.Threading;
using HaloTouch;
using UnityEngine;
using UnityEngine.InputSystem;
using UnityEngine.InputSystem.LowLevel;

static class Scene
{
    static readonly List<string> Lines = new List<string>();

    static int Main(string[] arguments)
    {
        var receiver = Add<HaloReceiver>("receiver");
        var surface = Add<HaloSurface>("surface");
        surface.Receiver = receiver;
        // Lying on the far left of the scene, turned by 90 degrees around y, and scaled by its user.
        surface.Marker = new GameObject("marker").transform;
        surface.Marker.position = new Vector3(-3, 1, 2);
        surface.Marker.rotation = Quaternion.LookRotation(new Vector3(1, 0, 0), new Vector3(0, 1, 0));
        surface.Marker.localScale = new Vector3(7, 7, 7);
        var projector = Add<HaloProjectorCamera>("camera");
        var camera = projector.gameObject.AddComponent<Camera>();
        projector.Surface = surface;
        var events = Add<HaloPointerEvents>("events");
        Set(events, "surface", surface);
        Listen(events);
        var screen = Add<HaloTouchscreen>("screen");
        Set(screen, "surface", surface);
        var second = Add<HaloTouchscreen>("a screen of another surface, without fingers");
        var other = Add<HaloSurface>("other surface");
        other.Receiver = Add<HaloReceiver>("other receiver");
        Set(second, "surface", other);
        receiver.FrameReceived += (from, frame) => Place(frame, surface, projector, camera);
        receiver.Down += (frame, contact) => { throw new InvalidOperationException("a handler's own error"); };
        receiver.Lost += (from, node) => Lines.Add("{\"lost\": \"" + node + "\"}");
        Set(receiver, "loop", false);
        receiver.Recording = new TextAsset(File.ReadAllText(arguments[0])) { name = "hands" };
        foreach (var each in new MonoBehaviour[] { surface, projector, events, screen, second }) Call(each, "OnEnable");
        receiver.FrameReceived += (from, frame) => Lines.Add("{\"slots\": [" + screen.Hover(0).ReadValue() + ", " + screen.Force(0).ReadValue() + "]}");
        for (var i = 0; i < 600 && receiver.Status != "the recording is over"; i++)
        {
            Call(receiver, "Update");
            Call(surface, "Update");
            Call(projector, "LateUpdate");
            Report();
            Thread.Sleep(2);
        }
        Lines.Add("{\"status\": \"" + receiver.Status + "\", \"connected\": " + (receiver.IsConnected ? "true" : "false") + "}");
        foreach (var each in new MonoBehaviour[] { second, screen, events, projector, surface, receiver }) Call(each, "OnDisable");
        Lines.Add("{\"devices\": " + InputSystem.Devices.Count + "}");
        Report();
        return 0;
    }

    static T Add<T>(string name) where T : Component => new GameObject(name).AddComponent<T>();

    // Unity calls these methods by their name, and sets private fields from the inspector.
    static void Call(object target, string method) =>
        target.GetType().GetMethod(method, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(target, null);

    static void Set(object target, string field, object value) =>
        target.GetType().GetField(field, BindingFlags.Instance | BindingFlags.NonPublic).SetValue(target, value);

    static void Listen(HaloPointerEvents events)
    {
        events.OnDown.AddListener(place => Lines.Add("{\"down\": " + Json(place) + "}"));
        events.OnStrike.AddListener(speed => Lines.Add("{\"strike\": " + Json(speed) + "}"));
        events.OnMove.AddListener(place => Lines.Add("{\"move\": " + Json(place) + "}"));
        events.OnPressure.AddListener(value => Lines.Add("{\"press\": " + Json(value) + "}"));
        events.OnUp.AddListener(place => Lines.Add("{\"up\": " + Json(place) + "}"));
        events.OnHover.AddListener(height => Lines.Add("{\"hover\": " + Json(height) + "}"));
        events.OnPointer.AddListener(pointer => Lines.Add("{\"pointer\": " + pointer.Id + "}"));
    }

    // Where each finger is in the world, and where on the projector's picture what lies below it is drawn.
    static void Place(HaloFrame frame, HaloSurface surface, HaloProjectorCamera projector, Camera camera)
    {
        foreach (var pointer in frame.Pointers)
        {
            if (!surface.IsAnchored || !projector.IsProjecting) continue;
            var below = surface.ToWorld(pointer.XMm, pointer.YMm, 0) - camera.transform.position;
            var t = camera.transform;
            var seen = new[] { Vector3.Dot(below, t.right), Vector3.Dot(below, t.up), -Vector3.Dot(below, t.forward), 1 };
            var clip = new float[4];
            for (var i = 0; i < 16; i++) clip[i / 4] += camera.projectionMatrix[i / 4, i % 4] * seen[i % 4];
            Lines.Add(
                "{\"finger\": " + pointer.Id + ", \"frame\": " + frame.Number + ", \"world\": " + Json(surface.ToWorld(pointer)) +
                ", \"drawn\": [" + Json(clip[0] / clip[3]) + ", " + Json(clip[1] / clip[3]) + "]}");
        }
    }

    static void Report()
    {
        foreach (var line in Lines) Console.WriteLine(line);
        Lines.Clear();
        foreach (TouchState touch in InputSystem.Queued)
            Console.WriteLine(
                "{\"touch\": \"" + touch.phase + "\", \"id\": " + touch.touchId + ", \"at\": [" + Json(touch.position.x) + ", " +
                Json(touch.position.y) + "], \"pressure\": " + Json(touch.pressure) + "}");
        InputSystem.Queued.Clear();
    }

    static string Json(float number) => number.ToString("R", CultureInfo.InvariantCulture);

    static string Json(Vector3 place) => "[" + Json(place.x) + ", " + Json(place.y) + ", " + Json(place.z) + "]";
}
