/* The thread pool: fixed-size work, claimed in index order, delivered in index order where the order matters. */
#ifndef HDR_POOL_H
#define HDR_POOL_H

#include "base.h"

typedef struct hdr_pool hdr_pool;

/* threads >= 1; the calling thread is one of them. */
hdr_pool *hdr_pool_new(int threads, hdr_error *err);
void hdr_pool_free(hdr_pool *pool);
int hdr_pool_threads(const hdr_pool *pool);

/* One job: item (0 ... items-1) on thread (0 ... threads-1). Anything but HDR_OK stops the run: no further item is
 * claimed, and the error of the lowest failed item is what hdr_pool_run returns, whatever the threads did. */
typedef hdr_status (*hdr_job)(void *context, int item, int thread, hdr_error *err);

/* Runs job for each item. Items are claimed in increasing order. */
hdr_status hdr_pool_run(hdr_pool *pool, int items, hdr_job job, void *context, hdr_error *err);

/* Called within a job: waits until all items below this one have called hdr_pool_leave (or the run was stopped: then
 * false, and the job returns HDR_OK without delivering). Between enter and leave no other item's is open. */
bool hdr_pool_enter(hdr_pool *pool, int item);
void hdr_pool_leave(hdr_pool *pool, int item);

/* Asks the run to stop early, without an error: no further item is claimed and hdr_pool_enter answers false. */
void hdr_pool_stop(hdr_pool *pool);
bool hdr_pool_stopped(const hdr_pool *pool);

#endif
