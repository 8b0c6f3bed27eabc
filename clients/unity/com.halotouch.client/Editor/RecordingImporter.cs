using System.IO;
using UnityEditor.AssetImporters;
using UnityEngine;

namespace HaloTouch.Editor
{
    // Makes a recorded stream (.jsonl) a text asset, so that it can be dropped on a Halo Receiver.
    [ScriptedImporter(1, "jsonl")]
    sealed class RecordingImporter : ScriptedImporter
    {
        public override void OnImportAsset(AssetImportContext context)
        {
            var text = new TextAsset(File.ReadAllText(context.assetPath));
            context.AddObjectToAsset("text", text);
            context.SetMainObject(text);
        }
    }
}
