function oi = edge_image()
% The slanted edge behind the lens.
oi = oiCompute(lens(), edge_scene());
end
