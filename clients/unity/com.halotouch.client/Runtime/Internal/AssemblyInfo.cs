using System.Runtime.CompilerServices;

// Everything in the namespace HaloTouch.Internal belongs to the package: it can change in any version.
[assembly: InternalsVisibleTo("HaloTouch")]
[assembly: InternalsVisibleTo("HaloTouch.Editor")]
[assembly: InternalsVisibleTo("HaloTouch.Tests")]
