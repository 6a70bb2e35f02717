// A clock for the trainee's page: a message every 16 ms.

setInterval(() => postMessage(0), 16);
