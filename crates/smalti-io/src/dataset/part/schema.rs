//! Columns in the form of the Parquet library.

use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::errors::ParquetError;
use parquet::schema::types::{PrimitiveTypeBuilder, SchemaDescPtr, SchemaDescriptor, Type};

use super::super::schema::{ColumnKind, ColumnSpec};

/// The schema in the form of the Parquet library.
pub(super) fn parquet(schema: &[ColumnSpec]) -> Result<SchemaDescPtr, ParquetError> {
    let fields = schema.iter().map(field).collect::<Result<_, _>>()?;
    let root = Type::group_type_builder("schema").with_fields(fields).build()?;
    Ok(Arc::new(SchemaDescriptor::new(Arc::new(root))))
}

fn field(spec: &ColumnSpec) -> Result<Arc<Type>, ParquetError> {
    fn leaf(name: &str, physical: Physical, repetition: Repetition) -> PrimitiveTypeBuilder<'_> {
        Type::primitive_type_builder(name, physical).with_repetition(repetition)
    }
    let built = match spec.kind {
        ColumnKind::Int => leaf(&spec.name, Physical::INT64, Repetition::REQUIRED).build()?,
        ColumnKind::Float => leaf(&spec.name, Physical::DOUBLE, Repetition::OPTIONAL).build()?,
        ColumnKind::Text => leaf(&spec.name, Physical::BYTE_ARRAY, Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::String))
            .with_converted_type(ConvertedType::UTF8)
            .build()?,
        ColumnKind::Floats => {
            let element = leaf("element", Physical::DOUBLE, Repetition::OPTIONAL).build()?;
            let list = Type::group_type_builder("list")
                .with_repetition(Repetition::REPEATED)
                .with_fields(vec![Arc::new(element)])
                .build()?;
            Type::group_type_builder(&spec.name)
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(Some(LogicalType::List))
                .with_converted_type(ConvertedType::LIST)
                .with_fields(vec![Arc::new(list)])
                .build()?
        }
    };
    Ok(Arc::new(built))
}
