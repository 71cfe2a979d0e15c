/*
 * Counts the statements that SQLite executes for each table. SQLite reports each statement on the thread of its connection.
 *
 * Every statement here uses one table. Its name comes first after FROM or INTO. Statements that use no table (transactions,
 * pragmas) count as "other". Reads of imagery are not counted here: which pages a drive reads depends on how far its loader threads are.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static const char *const names[STORE_TABLES] = {
	[STORE_BASE_TABLE] = "base",       [STORE_OFFSET_TABLE] = "offset", [STORE_DISTURBANCE_TABLE] = "dirt",
	[STORE_DEPOSITED_TABLE] = "heaped",   [STORE_PLASTIC_SINKAGE_TABLE] = "pressed", [STORE_SHEAR_TABLE] = "shear",
	[STORE_DUG_TABLE] = "dug",         [STORE_SETTLED_TABLE] = "settled", [STORE_LOOSE_TABLE] = "loose",
	[STORE_FLOOR_TABLE] = "floor",     [STORE_DENSITY_TABLE] = "density", [STORE_SLOPE_TABLE] = "slope",
	[STORE_HEALED_TABLE] = "healed", [STORE_RISEN_TABLE] = "risen", [STORE_GROWN_TABLE] = "grown",
	[STORE_META_TABLE] = "meta",       [STORE_RUN_TABLE] = "run",
	[STORE_HISTORY_TABLE] = "history", [STORE_REVISION_TABLE] = "revision", [STORE_NO_TABLE] = "other",
};
static_assert((int)STORE_BASE_TABLE == (int)ROW_BASE && (int)STORE_GROWN_TABLE == (int)ROW_GROWN, "tables in one order");

const char *store_table_name(enum store_table table)
{
	return names[table];
}

static enum store_table table_of(const char *sql, const char *word)
{
	const char *at = strstr(sql, word);
	if (at == NULL)
		return STORE_NO_TABLE;
	at += strlen(word);
	at += *at == '"';
	for (int table = 0; table < STORE_NO_TABLE; table++) {
		size_t length = strlen(names[table]);
		/* No name begins with another. */
		if (strncmp(at, names[table], length) == 0)
			return (enum store_table)table;
	}
	return STORE_NO_TABLE;
}

static int began(unsigned what, void *user, void *statement, void *text)
{
	struct statements *statements = user;
	const char *sql = text;
	bool reads = strncmp(sql, "SELECT", 6) == 0;
	if (reads && strstr(sql, " FROM imagery ") != NULL)
		return 0;
	enum store_table table = table_of(sql, strncmp(sql, "INSERT", 6) == 0 ? " INTO " : " FROM ");
	atomic_uint_fast64_t *count = reads ? &statements->read[table] : &statements->written[table];
	atomic_fetch_add_explicit(count, 1, memory_order_relaxed);
	return 0;
}

void store_statements_restart(struct statements *statements)
{
	for (int table = 0; table < STORE_TABLES; table++) {
		atomic_store_explicit(&statements->read[table], 0, memory_order_relaxed);
		atomic_store_explicit(&statements->written[table], 0, memory_order_relaxed);
	}
	for (int table = 0; table < ROW_TABLES; table++)
		atomic_store_explicit(&statements->inherited[table], 0, memory_order_relaxed);
}

void store_statements_count(struct statements *statements, sqlite3 *db)
{
	sqlite3_trace_v2(db, SQLITE_TRACE_STMT, began, statements);
}

/* --- the plan --- */

static void add(struct plan *plan, const char *verb, enum store_table table, int64_t amount, enum plan_unit unit,
		const char *effect)
{
	char name[32];
	snprintf(name, sizeof name, "%s %s", verb, names[table]);
	plan_add(plan, &(struct plan_line){.kind = PLAN_STATEMENT, .unit = unit, .effect = effect, .object = -1, .amount = amount},
		 name);
}

void store_plan_reads(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect)
{
	add(plan, "read", table, amount, unit, effect);
}

void store_plan_writes(struct plan *plan, enum store_table table, int64_t amount, enum plan_unit unit, const char *effect)
{
	add(plan, "write", table, amount, unit, effect);
}

void store_commit_plan(unsigned planes, bool was_deformed, const char *const effects[PLANES], struct plan *plan)
{
	for (int plane = 0; plane < PLANES; plane++) {
		enum store_table table = (enum store_table)row_table_of((enum plane)plane);
		const char *effect = effects[plane];
		if (planes & PLANE_BIT(plane)) {
			store_plan_reads(plan, table, 1, PLAN_COMMITTED, effect);
			/* The row, and what is below it. */
			if (!row_is_state(row_table_of((enum plane)plane)))
				store_plan_reads(plan, table, 2, PLAN_COMMITTED_COARSER, effect);
			store_plan_writes(plan, table, 1, PLAN_CHANGED, effect);
		} else if (planes != 0 && was_deformed && row_is_state(row_table_of((enum plane)plane))) {
			store_plan_reads(plan, table, 1, PLAN_LEFT, NULL);
			store_plan_writes(plan, table, 1, PLAN_CHANGED, NULL);
		}
	}
	if (planes != 0)
		store_plan_writes(plan, STORE_META_TABLE, 1, PLAN_CHANGED, effects[PLANE_OFFSET]);
	store_plan_writes(plan, STORE_RUN_TABLE, 1, PLAN_COMMIT, NULL);
	/* Where a commit begins and ends. */
	store_plan_writes(plan, STORE_NO_TABLE, 2, PLAN_COMMIT, NULL);
}

void store_history_plan(unsigned planes, const char *const effects[PLANES], struct plan *plan)
{
	for (int plane = 0; plane < PLANES; plane++)
		store_plan_reads(plan, (enum store_table)row_table_of((enum plane)plane), 1, PLAN_KEPT,
				 planes & PLANE_BIT(plane) ? effects[plane] : NULL);
	store_plan_reads(plan, STORE_HISTORY_TABLE, 1, PLAN_SOUGHT, NULL);
	store_plan_writes(plan, STORE_HISTORY_TABLE, 1, PLAN_KEPT, NULL);
	store_plan_writes(plan, STORE_REVISION_TABLE, 1, PLAN_KEPT, NULL);
}

/* --- what was executed --- */

void store_statements(const struct store *store, struct store_statements *out)
{
	*out = (struct store_statements){.sought = atomic_load_explicit(&store->statements.sought, memory_order_relaxed)};
	for (int table = 0; table < ROW_TABLES; table++) {
		out->inherited[table] = atomic_load_explicit(&store->statements.inherited[table], memory_order_relaxed);
		out->kept[table] = atomic_load_explicit(&store->statements.kept[table], memory_order_relaxed);
		out->kept[STORE_HISTORY_TABLE] += out->kept[table];
	}
	out->kept[STORE_REVISION_TABLE] = atomic_load_explicit(&store->statements.revisions, memory_order_relaxed);
	for (; store != NULL; store = store->under)
		for (int table = 0; table < STORE_TABLES; table++) {
			out->read[table] += atomic_load_explicit(&store->statements.read[table], memory_order_relaxed);
			out->written[table] += atomic_load_explicit(&store->statements.written[table], memory_order_relaxed);
		}
}
