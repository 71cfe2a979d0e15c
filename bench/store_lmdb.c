/* LMDB under the same keys and bytes as a store's rows: what raw reads are measured beside. */
#include "store_bench.h"

#if FURROW_LMDB
#include <lmdb.h>
#include <string.h>
#include <sys/stat.h>

#include "bench.h"

struct bench_lmdb {
	MDB_env *env;
	MDB_txn *txn;
	MDB_dbi table;
};

static void must(int code)
{
	if (code != 0)
		bench_must(fail_with(STATUS_FAILED, "lmdb: %s; free some space", mdb_strerror(code)));
}

bool bench_lmdb_create(const char *folder, size_t room, struct bench_lmdb **out)
{
	struct bench_lmdb *lmdb = mem_calloc(1, sizeof *lmdb);
	if (lmdb == NULL)
		bench_must(fail_memory("lmdb"));
	if (mkdir(folder, 0700) != 0)
		bench_must(fail_with(STATUS_FAILED, "%s: cannot be made; free some space", folder));
	must(mdb_env_create(&lmdb->env));
	must(mdb_env_set_mapsize(lmdb->env, room));
	must(mdb_env_open(lmdb->env, folder, MDB_NOSYNC, 0600));
	must(mdb_txn_begin(lmdb->env, NULL, 0, &lmdb->txn));
	must(mdb_dbi_open(lmdb->txn, NULL, MDB_INTEGERKEY, &lmdb->table));
	*out = lmdb;
	return true;
}

void bench_lmdb_put(struct bench_lmdb *lmdb, uint64_t key, const void *bytes, size_t size)
{
	MDB_val name = {sizeof key, &key}, value = {size, (void *)(uintptr_t)bytes};
	must(mdb_put(lmdb->txn, lmdb->table, &name, &value, MDB_APPEND));
}

/* From here on it is read: a transaction is kept and renewed for each, as SQLite begins one. */
void bench_lmdb_commit(struct bench_lmdb *lmdb)
{
	must(mdb_txn_commit(lmdb->txn));
	must(mdb_txn_begin(lmdb->env, NULL, MDB_RDONLY, &lmdb->txn));
	mdb_txn_reset(lmdb->txn);
}

size_t bench_lmdb_get(struct bench_lmdb *lmdb, uint64_t key, void *bytes, size_t room)
{
	MDB_val name = {sizeof key, &key}, value;
	must(mdb_txn_renew(lmdb->txn));
	must(mdb_get(lmdb->txn, lmdb->table, &name, &value));
	size_t size = value.mv_size < room ? value.mv_size : room;
	memcpy(bytes, value.mv_data, size);
	mdb_txn_reset(lmdb->txn);
	return size;
}

void bench_lmdb_destroy(struct bench_lmdb *lmdb)
{
	if (lmdb == NULL)
		return;
	mdb_txn_abort(lmdb->txn);
	mdb_env_close(lmdb->env);
	mem_free(lmdb);
}

#else

bool bench_lmdb_create(const char *folder, size_t room, struct bench_lmdb **out)
{
	*out = NULL;
	return false;
}

void bench_lmdb_put(struct bench_lmdb *lmdb, uint64_t key, const void *bytes, size_t size)
{
}

void bench_lmdb_commit(struct bench_lmdb *lmdb)
{
}

size_t bench_lmdb_get(struct bench_lmdb *lmdb, uint64_t key, void *bytes, size_t room)
{
	return 0;
}

void bench_lmdb_destroy(struct bench_lmdb *lmdb)
{
}

#endif
