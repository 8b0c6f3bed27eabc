using UnityEngine;
using UnityEngine.InputSystem;
using UnityEngine.InputSystem.Controls;
using UnityEngine.InputSystem.LowLevel;
using TouchPhase = UnityEngine.InputSystem.TouchPhase;

namespace HaloTouch
{
    /// <summary>
    /// Makes the fingers a touchscreen of the Input System: UI Toolkit, uGUI (with the Input System's
    /// module) and code for gestures work with it. Each touch has its pressure. The device has more
    /// controls: `hover0` to `hover9` (mm above the surface, 0 in touch, -1 without a finger) and
    /// `force0` to `force9` (grams, -1 if unknown), by slot.
    /// </summary>
    [AddComponentMenu("Halo Touch/Halo Touchscreen (Input System)")]
    public sealed class HaloTouchscreen : MonoBehaviour
    {
        const float NoFinger = -1;

        [SerializeField]
        HaloSurface surface = null;

        readonly AxisControl[] _hover = new AxisControl[HaloTouchscreenLayout.Slots];
        readonly AxisControl[] _force = new AxisControl[HaloTouchscreenLayout.Slots];
        HaloReceiver _receiver;

        /// <summary>The device while this component is enabled, or null.</summary>
        public Touchscreen Device { get; private set; }

        /// <summary>Height of the finger of a slot in mm: 0 in touch, -1 without a finger.</summary>
        public AxisControl Hover(int slot) => _hover[slot];

        /// <summary>Force of the finger of a slot in grams: -1 if it is unknown.</summary>
        public AxisControl Force(int slot) => _force[slot];

        void OnEnable()
        {
            _receiver = surface == null ? null : surface.Receiver;
            if (_receiver == null)
            {
                Debug.LogError("Halo Touch: give the touchscreen a surface with a receiver", this);
                return;
            }
            // Registered again, the layout would replace the devices of other surfaces.
            if (InputSystem.LoadLayout(HaloTouchscreenLayout.Name) == null)
                InputSystem.RegisterLayout(HaloTouchscreenLayout.Json());
            Device = (Touchscreen)InputSystem.AddDevice(HaloTouchscreenLayout.Name);
            for (var slot = 0; slot < HaloTouchscreenLayout.Slots; slot++)
            {
                _hover[slot] = Device.GetChildControl<AxisControl>(HaloTouchscreenLayout.Hover + slot);
                _force[slot] = Device.GetChildControl<AxisControl>(HaloTouchscreenLayout.Force + slot);
                SetSlot(slot, NoFinger, NoFinger);
            }
            _receiver.FrameReceived += SetSlots;
            _receiver.Down += Begin;
            _receiver.Moved += Move;
            _receiver.Up += End;
        }

        void OnDisable()
        {
            if (Device == null) return;
            _receiver.FrameReceived -= SetSlots;
            _receiver.Down -= Begin;
            _receiver.Moved -= Move;
            _receiver.Up -= End;
            InputSystem.RemoveDevice(Device);
            Device = null;
        }

        void SetSlots(HaloReceiver receiver, HaloFrame frame)
        {
            for (var slot = 0; slot < HaloTouchscreenLayout.Slots; slot++)
            {
                float hoverMm = NoFinger, forceG = NoFinger;
                foreach (var pointer in frame.Pointers)
                {
                    if (pointer.Slot != slot) continue;
                    hoverMm = pointer.HoverMm;
                    forceG = pointer.ForceG;
                }
                SetSlot(slot, hoverMm, forceG);
            }
        }

        void SetSlot(int slot, float hoverMm, float forceG)
        {
            InputState.Change(_hover[slot], hoverMm);
            InputState.Change(_force[slot], forceG);
        }

        void Begin(HaloFrame frame, HaloContact contact)
        {
            frame.TryGetPointer(contact.Id, out var pointer); // 0 if it has already left
            Queue(TouchPhase.Began, contact.Id, contact.U, contact.V, pointer.Pressure);
        }

        void Move(HaloFrame frame, HaloPointer pointer)
        {
            Queue(TouchPhase.Moved, pointer.Id, pointer.U, pointer.V, pointer.Pressure);
        }

        void End(HaloFrame frame, HaloContact contact)
        {
            Queue(TouchPhase.Ended, contact.Id, contact.U, contact.V, 0);
        }

        void Queue(TouchPhase phase, int id, float u, float v, float pressure)
        {
            InputSystem.QueueStateEvent(
                Device,
                new TouchState
                {
                    phase = phase,
                    touchId = id % int.MaxValue + 1, // 0 is no id
                    position = surface.ToScreen(u, v),
                    pressure = pressure,
                });
        }
    }
}
