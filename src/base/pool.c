/* The thread pool. Threads sleep between runs. A run hands out its items by one atomic counter; the only lock that a
 * job meets is that of hdr_pool_enter and hdr_pool_leave, held for a few instructions.
 *
 * Why the lowest failed item's error always wins: items are claimed in increasing order, so all items below a failed
 * one have been claimed; those run to their end, and may still enter, because only items above a failed one are turned
 * away. Whether an item fails therefore depends on it and those below it alone, not on the order in which threads come
 * along. */
#include "base/pool.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

/* One call of hdr_pool_run. */
typedef struct run {
    hdr_pool *pool;
    hdr_job job;
    void *context;
    int items;
    atomic_llong next;        /* the next item to be claimed; items or more: none is left */
    atomic_int lowest_failed; /* INT_MAX: none. Written under the pool's lock */
    atomic_bool stopped;      /* hdr_pool_stop was called. Written under the pool's lock */
    int turn;                 /* the item that may enter: all below it have left. Under the pool's lock */
    hdr_error error;          /* of lowest_failed. Under the pool's lock */
} run;

struct hdr_pool {
    int threads;
    pthread_t *workers; /* threads - 1 of them; the calling thread is the other */
    pthread_mutex_t lock;
    pthread_cond_t opened;   /* a run was opened, or the pool closes */
    pthread_cond_t finished; /* the last worker has left the run */
    pthread_cond_t turned;   /* a run's turn went on, or it was stopped */
    unsigned long runs;      /* how many were opened: tells a worker which it has seen */
    bool open, closing;      /* workers may join the run; workers end */
    int joined;              /* workers within the run */
    run run;
};

typedef struct worker_start {
    hdr_pool *pool;
    int thread;
} worker_start;

/* The run whose job this thread is in: a job may itself call hdr_pool_run, and then has to do with the inner run. */
static _Thread_local run *current_run;

static run *run_of(const hdr_pool *pool) {
    return current_run && current_run->pool == pool ? current_run : (run *)&pool->run;
}

/* ---- Work ---- */

static void claim_no_more(run *r) {
    atomic_store(&r->next, (long long)r->items);
}

static void item_failed(run *r, int item, hdr_status status, const hdr_error *error) {
    pthread_mutex_lock(&r->pool->lock);
    if (item < atomic_load(&r->lowest_failed)) {
        atomic_store(&r->lowest_failed, item);
        r->error = *error;
        r->error.status = status;
    }
    claim_no_more(r);
    pthread_cond_broadcast(&r->pool->turned);
    pthread_mutex_unlock(&r->pool->lock);
}

static void work(run *r, int thread) {
    run *outer = current_run;
    current_run = r;
    hdr_error error;
    for (;;) {
        long long item = atomic_fetch_add(&r->next, 1);
        if (item >= r->items) break;
        if (atomic_load(&r->lowest_failed) < item) break;
        error.status = HDR_OK;
        error.message[0] = '\0';
        hdr_status status = r->job(r->context, (int)item, thread, &error);
        if (status != HDR_OK) item_failed(r, (int)item, status, &error);
    }
    current_run = outer;
}

static void *worker_main(void *argument) {
    worker_start start = *(worker_start *)argument;
    free(argument);
    hdr_pool *pool = start.pool;
    unsigned long seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->closing && !(pool->open && pool->runs != seen))
            pthread_cond_wait(&pool->opened, &pool->lock);
        if (pool->closing) break;
        seen = pool->runs;
        pool->joined++;
        pthread_mutex_unlock(&pool->lock);
        work(&pool->run, start.thread);
        pthread_mutex_lock(&pool->lock);
        if (--pool->joined == 0) pthread_cond_signal(&pool->finished);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* ---- Making and ending a pool ---- */

static bool start_worker(hdr_pool *pool, int thread) {
    worker_start *start = hdr_alloc(1, sizeof *start);
    if (!start) return false;
    start->pool = pool;
    start->thread = thread;
    if (pthread_create(&pool->workers[thread - 1], NULL, worker_main, start) != 0) {
        free(start);
        return false;
    }
    return true;
}

hdr_pool *hdr_pool_new(int threads, hdr_error *err) {
    threads = threads < 1 ? 1 : threads;
    hdr_pool *pool = hdr_alloc(1, sizeof *pool);
    pthread_t *workers = hdr_alloc((size_t)threads, sizeof *workers);
    if (!pool || !workers) {
        free(pool);
        free(workers);
        hdr_fail(err, HDR_INTERNAL, "out of memory for %d threads", threads);
        return NULL;
    }
    pool->workers = workers;
    pool->threads = threads;
    pool->run.pool = pool;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->opened, NULL);
    pthread_cond_init(&pool->finished, NULL);
    pthread_cond_init(&pool->turned, NULL);
    for (int thread = 1; thread < threads; thread++)
        if (!start_worker(pool, thread)) {
            /* A system that gives fewer threads gets the same result later. */
            pool->threads = thread;
            break;
        }
    return pool;
}

void hdr_pool_free(hdr_pool *pool) {
    if (!pool) return;
    pthread_mutex_lock(&pool->lock);
    pool->closing = true;
    pthread_cond_broadcast(&pool->opened);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->threads - 1; i++)
        pthread_join(pool->workers[i], NULL);
    pthread_cond_destroy(&pool->turned);
    pthread_cond_destroy(&pool->finished);
    pthread_cond_destroy(&pool->opened);
    pthread_mutex_destroy(&pool->lock);
    free(pool->workers);
    free(pool);
}

int hdr_pool_threads(const hdr_pool *pool) {
    return pool->threads;
}

/* ---- Running ---- */

static void prepare(run *r, hdr_pool *pool, int items, hdr_job job, void *context) {
    r->pool = pool;
    r->job = job;
    r->context = context;
    r->items = items;
    atomic_store(&r->next, 0);
    atomic_store(&r->lowest_failed, INT_MAX);
    atomic_store(&r->stopped, false);
    r->turn = 0;
    r->error.status = HDR_OK;
    r->error.message[0] = '\0';
}

static hdr_status result_of(const run *r, hdr_error *err) {
    if (r->error.status == HDR_OK) return HDR_OK;
    return hdr_fail(err, r->error.status, "%s", r->error.message);
}

/* A run within a job has this thread only: the others are busy with the outer run. */
static hdr_status run_within_job(hdr_pool *pool, int items, hdr_job job, void *context, hdr_error *err) {
    run inner;
    prepare(&inner, pool, items, job, context);
    work(&inner, 0);
    return result_of(&inner, err);
}

hdr_status hdr_pool_run(hdr_pool *pool, int items, hdr_job job, void *context, hdr_error *err) {
    if (current_run && current_run->pool == pool) return run_within_job(pool, items, job, context, err);
    bool shared = pool->threads > 1 && items > 1;
    pthread_mutex_lock(&pool->lock);
    prepare(&pool->run, pool, items, job, context);
    if (shared) {
        pool->runs++;
        pool->open = true;
        pthread_cond_broadcast(&pool->opened);
    }
    pthread_mutex_unlock(&pool->lock);

    work(&pool->run, 0);

    /* Nothing is left to claim. Who has not woken up by now need not come. */
    pthread_mutex_lock(&pool->lock);
    pool->open = false;
    while (pool->joined > 0)
        pthread_cond_wait(&pool->finished, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    return result_of(&pool->run, err);
}

/* ---- Order ---- */

static bool turned_away(run *r, int item) {
    return atomic_load(&r->stopped) || atomic_load(&r->lowest_failed) < item;
}

bool hdr_pool_enter(hdr_pool *pool, int item) {
    run *r = run_of(pool);
    pthread_mutex_lock(&pool->lock);
    while (r->turn != item && !turned_away(r, item))
        pthread_cond_wait(&pool->turned, &pool->lock);
    bool may = !turned_away(r, item);
    pthread_mutex_unlock(&pool->lock);
    return may;
}

void hdr_pool_leave(hdr_pool *pool, int item) {
    run *r = run_of(pool);
    pthread_mutex_lock(&pool->lock);
    if (r->turn == item) {
        r->turn = item + 1;
        pthread_cond_broadcast(&pool->turned);
    }
    pthread_mutex_unlock(&pool->lock);
}

void hdr_pool_stop(hdr_pool *pool) {
    run *r = run_of(pool);
    pthread_mutex_lock(&pool->lock);
    atomic_store(&r->stopped, true);
    claim_no_more(r);
    pthread_cond_broadcast(&pool->turned);
    pthread_mutex_unlock(&pool->lock);
}

bool hdr_pool_stopped(const hdr_pool *pool) {
    return atomic_load(&run_of(pool)->stopped);
}
