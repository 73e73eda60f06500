"""Independent tasks on several cores: `working` tells how many processes there may be, `each` and `ahead` have tasks
done.

A task is a pure function at the top of a module, of one object that all tasks of a call share and of an item of its
own. Its result is the same in whatever process and order it runs: linear algebra works on one thread everywhere, and a
task in this process gets its arrays as pickling leaves them, contiguous and not to be written to, because the last bit
of a scalar product depends on how its factors lie in memory.

Processes are started once the work at hand takes longer than they take to start, and stay until the block of `working`
ends. There is one less than may work, for this process does not only wait: it does what it asks for where that is not
begun, and what comes next while another is at it. What tasks share is written to a file once and mapped into the memory
of each process; a large result comes back the same way. A process ends by itself when this one has gone, leaves
keyboard interrupts to it, and abandons a task whose result is no longer wanted.

Reading order: tasks (`each`, `ahead`), crew (`working`), results, pool (processes beside this one), process (what is
done in these), sending (objects on their way), threads.
"""

from robotid.parallel.crew import computing, workers, working
from robotid.parallel.tasks import ahead, each, expect
from robotid.parallel.threads import ONE_THREAD, one_thread

__all__ = ["ONE_THREAD", "ahead", "computing", "each", "expect", "one_thread", "workers", "working"]
