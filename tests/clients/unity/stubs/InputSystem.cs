// Signatures of the package com.unity.inputsystem, written by hand from its public documentation (1.7). See
// UnityEngine.cs.
namespace UnityEngine.InputSystem
{
    public abstract class InputControl
    {
    }

    public abstract class InputControl<TValue> : InputControl where TValue : struct
    {
        public TValue ReadValue() => throw null;
    }

    public class InputDevice : InputControl
    {
        public TControl GetChildControl<TControl>(string path) where TControl : InputControl => throw null;
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
        public static void RegisterLayout(string json, string name = null, Layouts.InputDeviceMatcher? matches = null) => throw null;
        public static InputDevice AddDevice(string layout, string name = null, string variants = null) => throw null;
        public static void RemoveDevice(InputDevice device) => throw null;
        public static void QueueStateEvent<TState>(InputDevice device, TState state, double time = -1)
            where TState : struct, LowLevel.IInputStateTypeInfo => throw null;
    }
}

namespace UnityEngine.InputSystem.Layouts
{
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
            InputEventPtr eventPtr = default(InputEventPtr)) where TState : struct => throw null;
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
