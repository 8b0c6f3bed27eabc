// Stand-ins for the package com.unity.inputsystem, written by hand from its public documentation (1.7). See
// UnityEngine.cs. They record what is queued.
using System;
using System.Collections.Generic;

namespace UnityEngine.InputSystem
{
    public abstract class InputControl
    {
    }

    public abstract class InputControl<TValue> : InputControl where TValue : struct
    {
        public TValue Value;
        public TValue ReadValue() => Value;
    }

    public class InputDevice : InputControl
    {
        readonly Dictionary<string, InputControl> _children = new Dictionary<string, InputControl>();

        // The layout's text must name the control.
        public TControl GetChildControl<TControl>(string path) where TControl : InputControl
        {
            if (!InputSystem.Layout.Contains("\"name\": \"" + path + "\"")) throw new ArgumentException("no control " + path);
            if (!_children.ContainsKey(path)) _children[path] = Activator.CreateInstance<TControl>();
            return (TControl)_children[path];
        }
    }

    public class Pointer : InputDevice
    {
    }

    public class Touchscreen : Pointer
    {
    }

    public enum TouchPhase { None, Began, Moved, Ended, Canceled, Stationary }

    public static class InputSystem
    {
        public static string Layout = "";
        public static readonly List<object> Queued = new List<object>();
        public static readonly List<InputDevice> Devices = new List<InputDevice>();

        public static void RegisterLayout(string json, string name = null, Layouts.InputDeviceMatcher? matches = null)
        {
            if (Devices.Count > 0) throw new InvalidOperationException("devices of the layout would be created again");
            Layout = json;
        }

        public static Layouts.InputControlLayout LoadLayout(string name) =>
            Layout.Contains("\"name\": \"" + name + "\"") ? new Layouts.InputControlLayout() : null;

        public static InputDevice AddDevice(string layout, string name = null, string variants = null)
        {
            if (!Layout.Contains("\"name\": \"" + layout + "\"")) throw new ArgumentException("no layout " + layout);
            Devices.Add(new Touchscreen());
            return Devices[Devices.Count - 1];
        }

        public static void RemoveDevice(InputDevice device) => Devices.Remove(device);

        public static void QueueStateEvent<TState>(InputDevice device, TState state, double time = -1)
            where TState : struct, LowLevel.IInputStateTypeInfo => Queued.Add(state);
    }
}

namespace UnityEngine.InputSystem.Layouts
{
    public class InputControlLayout
    {
    }

    public struct InputDeviceMatcher
    {
    }
}

namespace UnityEngine.InputSystem.Controls
{
    public class AxisControl : InputControl<float>
    {
    }
}

namespace UnityEngine.InputSystem.Utilities
{
    public struct FourCC
    {
    }
}

namespace UnityEngine.InputSystem.LowLevel
{
    public enum InputUpdateType { None }

    public struct InputEventPtr
    {
    }

    public interface IInputStateTypeInfo
    {
        Utilities.FourCC format { get; }
    }

    public static class InputState
    {
        public static void Change<TState>(
            InputControl control, TState state, InputUpdateType updateType = default(InputUpdateType),
            InputEventPtr eventPtr = default(InputEventPtr)) where TState : struct =>
            ((InputControl<TState>)control).Value = state;
    }

    public struct TouchState : IInputStateTypeInfo
    {
        public int touchId;
        public Vector2 position;
        public Vector2 delta;
        public float pressure;
        public TouchPhase phase { get; set; }
        public Utilities.FourCC format => throw null;
    }
}
