// All topics in one process, one after the other, and then what they have seen of the schema.
// A topic alone: `node --test topics/NAME.mjs` with the programs in the environment.
import './topics/document.mjs';
import './topics/methods.mjs';
import './topics/states.mjs';
import './topics/prefer.mjs';
import './topics/events.mjs';
import './topics/idempotency.mjs';
import './topics/cache.mjs';
import './topics/results.mjs';
import './topics/uploads.mjs';
import './topics/encodings.mjs';
import './topics/expect.mjs';
import './topics/options.mjs';
import './topics/keys.mjs';
import './topics/cors.mjs';
import './topics/limits.mjs';
import './topics/lifecycle.mjs';
import './topics/admin.mjs';
import './topics/tracing.mjs';
import './topics/transport.mjs';
import './topics/coverage.mjs';
