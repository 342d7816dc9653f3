
/* The latest rows of a picture: row r is kept in place r % kept, X, Y and Z one after the other. */
typedef struct {
    @number@ *data;
    int32_t rows, cols, kept;
    int32_t ready; /* the rows below are computed */
} @p@_picture;

/* The place in 0..len-1 of one beyond the ends, mirrored about the outermost. */
static inline int32_t @p@_mirrored(int32_t at, int32_t len)
{
    int32_t m;
    if (at >= 0 && at < len)
        return at;
    if (len < 2)
        return 0;
    m = @p@_modulo(at, 2 * (len - 1));
    return m < len ? m : 2 * (len - 1) - m;
}

static inline @number@ *@p@_line(const @p@_picture *p, int32_t plane, int32_t row)
{
    return p->data + ((size_t)(@p@_mirrored(row, p->rows) % p->kept) * 3 + (size_t)plane) * (size_t)p->cols;
}

static inline @number@ @p@_at(const @p@_picture *p, int32_t plane, int32_t row, int32_t col)
{
    return @p@_line(p, plane, row)[@p@_mirrored(col, p->cols)];
}

/* A sample of Y, of which negative ones count as 0. */
static inline @number@ @p@_light(const @p@_picture *p, int32_t row, int32_t col)
{
    const @number@ y = @p@_at(p, 1, row, col);
    return y > 0 ? y : 0;
}
