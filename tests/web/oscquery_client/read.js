// Prints what the npm package oscquery reads from the server at the given port.
import oscquery from "oscquery";

const discovery = new oscquery.OSCQueryDiscovery();
const service = await discovery.queryNewService("127.0.0.1", Number(process.argv[2]));
const nodes = Object.fromEntries(
  service.flat().map((node) => [
    node.full_path,
    {
      description: node.description,
      values: node.arguments?.map((each) => each.value ?? null),
      ranges: node.arguments?.map((each) => each.range ?? null),
    },
  ]),
);
console.log(JSON.stringify({ host: service.hostInfo, nodes }));
